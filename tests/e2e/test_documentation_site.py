"""The documentation as a site: no warning while it is built, whole, and silent on the network."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import matplotlib
from docs._ext.check_site import Page, problems
from docs._ext.commands import contexts
from docs._ext.file_keys import SCHEMAS, anchor, read_schema
from docs._ext.rooms import home_of
from playwright.sync_api import sync_playwright

from stiffkit.cli.commands import main

ROOT = Path(__file__).parents[2]


def build(folder: Path) -> None:
    """Build the site as `make docs` does; warnings are errors, notebooks are run."""
    environment = {
        **os.environ,
        "MPLCONFIGDIR": matplotlib.get_cachedir(),
        "JUPYTER_RUNTIME_DIR": str(folder / "jupyter"),
        "XDG_CACHE_HOME": str(folder / "cache"),
    }
    options = ["-q", "-W", "--keep-going", "-d", str(folder / "trees")]
    done = subprocess.run(
        [sys.executable, "-m", "sphinx", *options, "docs", str(folder / "site")],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr


def keys_of(schema: dict[str, Any], path: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the path of every key of a part of a schema, as the reference names it."""
    for holder in (schema, schema.get("additionalProperties")):
        if isinstance(holder, dict):
            for key, value in holder.get("properties", {}).items():
                yield (*path, key)
                yield from keys_of(value, (*path, key))


def missing_keys(site: Path, kind: str) -> list[str]:
    schema = read_schema(kind)
    page = Page((site / "reference" / "files" / f"{kind}.html").read_text("utf-8"))
    paths = [*keys_of(schema)]
    for name, part in schema["$defs"].items():
        paths += [(name,), *keys_of(part, (name,))]
    return [str(path) for path in paths if anchor(kind, *path) not in page.anchors]


def missing_commands(site: Path) -> list[str]:
    page = Page((site / "reference" / "commands.html").read_text("utf-8"))
    paths = [context.command_path for context in contexts(main)]
    assert "stiffkit map" in paths
    return [path for path in paths if path.replace(" ", "-") not in page.anchors]


def rooms() -> list[str]:
    """Return all packages but the top level."""
    files = (ROOT / "src" / "stiffkit").glob("*/__init__.py")
    return [f"stiffkit.{file.parent.name}" for file in files]


def missing_names(site: Path) -> list[str]:
    missing = []
    for package in ["stiffkit", *rooms()]:
        page_of = package.rpartition(".")[2] if package != "stiffkit" else "index"
        file = site / "reference" / "api" / f"{page_of}.html"
        if not file.is_file():
            missing.append(f"{package}: the page is missing, add docs/reference/api/{page_of}.rst")
            continue
        anchors = Page(file.read_text("utf-8")).anchors
        names = getattr(import_module(package), "__all__", [])
        missing += [
            f"{package}.{name}"
            for name in names
            if name != "__version__"
            and home_of(package, name) == package
            and f"{package}.{name}" not in anchors
        ]
    return missing


def missing_pages(site: Path) -> list[str]:
    """Return the pages of the sources that the home page's navigation does not lead to."""
    home = Page((site / "index.html").read_text("utf-8"))
    linked = {reference.target.partition("#")[0] for reference in home.references}
    sources = [path for end in ("md", "rst", "ipynb") for path in (ROOT / "docs").rglob(f"*.{end}")]
    pages = [str(path.relative_to(ROOT / "docs").with_suffix(".html")) for path in sources]
    return [page for page in pages if page not in linked and page != "index.html"]


def loads(page: Path) -> list[str]:
    """Return the addresses on the network that a page asks for when a browser shows it."""
    chromium = shutil.which("chromium")
    assert chromium is not None, "the tests need Debian's chromium"
    asked: list[str] = []
    with sync_playwright() as player:
        browser = player.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        shown = browser.new_page()
        shown.on("request", lambda request: asked.append(request.url))
        shown.goto(page.as_uri())
        shown.wait_for_load_state("load")
        browser.close()
    assert page.as_uri() in asked
    return [url for url in asked if not url.startswith(("file:", "data:"))]


def test_the_site_is_whole(tmp_path: Path) -> None:
    build(tmp_path)
    site = tmp_path / "site"
    assert problems(site) == []
    assert missing_pages(site) == []
    for kind in SCHEMAS:
        assert missing_keys(site, kind) == []
    assert missing_commands(site) == []
    assert missing_names(site) == []
    theory = (site / "theory.html").read_text("utf-8")
    assert "<math" in theory
    assert "$" not in re.sub(r"<[^>]+>", "", theory)
    for notebook in (ROOT / "docs" / "notebooks").glob("*.ipynb"):
        shown = (site / "notebooks" / notebook.with_suffix(".html").name).read_text("utf-8")
        assert "cell_output" in shown
        assert "<img" in shown
    assert loads(site / "notebooks" / "stiffness-map.html") == []


def test_what_a_page_asks_for_is_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text('<img src="https://site.invalid/x.png">', encoding="utf-8")
    assert loads(page) == ["https://site.invalid/x.png"]


def test_what_is_wrong_with_a_site_is_found(tmp_path: Path) -> None:
    (tmp_path / "a.html").write_text(
        '<h1 id="here">A</h1><a href="#here">1</a><a href="b.html">2</a><a href="#there">3</a>'
        '<a href="http://example.org">4</a><img src="https://example.org/x.png">'
        '<style>p {background: url("//example.org/y.png")}</style><a href="../c.html">5</a>',
        encoding="utf-8",
    )
    (tmp_path / "s.css").write_text("@import 'https://example.org/z.css';", encoding="utf-8")
    found = [line.split(": ")[1] for line in problems(tmp_path)]
    assert found == [
        "b.html",
        "#there",
        "http://example.org",
        "https://example.org/x.png",
        "//example.org/y.png",
        "../c.html",
        "https://example.org/z.css",
    ]
