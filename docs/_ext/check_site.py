"""Whether a built site holds together: ``python docs/_ext/check_site.py FOLDER``.

Links must lead to pages and places that exist, whatever a page loads must lie in the site, and
links out must have the form of one; these are not followed.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import NamedTuple
from urllib.parse import unquote, urlsplit

_LOADS = {
    ("img", "src"),
    ("script", "src"),
    ("iframe", "src"),
    ("source", "src"),
    ("video", "src"),
    ("audio", "src"),
    ("embed", "src"),
    ("object", "data"),
    ("image", "href"),
    ("use", "href"),
    ("link", "href"),
}
_IN_STYLE = re.compile(r"(?:url\(|@import)\s*['\"]?([^'\")\s;]+)")


class Reference(NamedTuple):
    """Something that a page names."""

    target: str
    is_loaded: bool


class Page(HTMLParser):
    """The anchors and references of a page."""

    def __init__(self, text: str) -> None:
        """Read a page."""
        super().__init__()
        self.anchors: set[str] = set()
        self.references: list[Reference] = []
        self._in_style = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take what one element names."""
        self._in_style = tag == "style"
        for name, value in attrs:
            if value is None:
                continue
            if name == "id" or (tag == "a" and name == "name"):
                self.anchors.add(value)
            elif (tag, name) == ("a", "href"):
                self.references.append(Reference(value, is_loaded=False))
            elif (tag, name) in _LOADS:
                self.references.append(Reference(value, is_loaded=True))
            elif name == "srcset":
                for one in value.split(","):
                    self.references.append(Reference(one.split()[0], is_loaded=True))
            elif name == "style":
                self._take_style(value)

    def handle_data(self, data: str) -> None:
        """Take what a style sheet in the page names."""
        if self._in_style:
            self._take_style(data)

    def handle_endtag(self, tag: str) -> None:
        """Leave a style sheet."""
        self._in_style = self._in_style and tag != "style"

    def _take_style(self, text: str) -> None:
        self.references += [Reference(one, is_loaded=True) for one in _IN_STYLE.findall(text)]


def problems(site: Path) -> list[str]:
    """Return what is wrong with a built site, a line for each."""
    site = site.resolve()
    pages = {path: Page(path.read_text("utf-8")) for path in sorted(site.rglob("*.html"))}
    found = [
        f"{path.relative_to(site)}: {reference.target}: {wrong}"
        for path, page in pages.items()
        for reference in page.references
        if (wrong := _wrong(reference, path, site, pages))
    ]
    return found + list(_wrong_styles(site))


def _wrong(reference: Reference, path: Path, site: Path, pages: dict[Path, Page]) -> str:
    """Return what is wrong with a reference, nothing if it is right."""
    target, is_loaded = reference
    url = urlsplit(target)
    if url.scheme == "data":
        return ""
    if url.scheme or url.netloc:
        if is_loaded:
            return "is loaded from elsewhere"
        well_formed = url.scheme == "https" and "." in url.netloc and " " not in target
        return "" if well_formed else "is no address of the form https://HOST/..."
    file = (path.parent / unquote(url.path)).resolve() if url.path else path
    if site not in file.parents or not file.is_file():
        return "there is no such file in the site"
    page = pages.get(file)
    if url.fragment and page is not None and unquote(url.fragment) not in page.anchors:
        return "there is no such place on the page"
    return ""


def _wrong_styles(site: Path) -> Iterator[str]:
    for path in sorted(site.rglob("*.css")):
        for target in _IN_STYLE.findall(path.read_text("utf-8")):
            url = urlsplit(target)
            if url.scheme != "data" and (url.scheme or url.netloc):
                yield f"{path.relative_to(site)}: {target}: is loaded from elsewhere"


def main() -> None:
    """Print what is wrong, and end with status 1 if anything is."""
    found = problems(Path(sys.argv[1]).resolve())
    print("\n".join(found) or "every link leads somewhere")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
