"""What a strict reader finds wrong with a page, and what is packed into it."""

from __future__ import annotations

import base64
import gzip
from html.parser import HTMLParser

VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta", "source", "wbr"}
HEADINGS = ("h1", "h2", "h3", "h4", "h5", "h6")
CONTROLS = ("input", "select", "textarea", "output")
BLOCKS = {"div", "section", "table", "ul", "ol", "p", "figure", "details", "h1", "h2", "h3", "main"}
CHILDREN = {"ul": ("li",), "tr": ("th", "td"), "thead": ("tr",), "tbody": ("tr",)}


def unpacked(text: str) -> str:
    """Return what `stiffkit.report.template.packed` packed."""
    return gzip.decompress(base64.b64decode(text)).decode("utf-8")


class StrictReader(HTMLParser):
    """Reads a page as it is written, and mends nothing. ``faults`` are in words."""

    def __init__(self, html: str) -> None:
        super().__init__(convert_charrefs=True)
        self.faults: list[str] = []
        self.ids: set[str] = set()
        self.tags: list[str] = []
        self._open: list[str] = []
        self._references: list[str] = []
        self._level = 0
        self._title = ""
        if not html.startswith("<!DOCTYPE html>\n"):
            self.faults.append("no doctype at the start")
        self.feed(html)
        self.close()
        self._judge_the_whole()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        at = f"<{tag}> in line {self.getpos()[0]}"
        parent = self._open[-1] if self._open else ""
        if len(given) < len(attrs):
            self.faults.append(f"an attribute twice: {at}")
        if tag in BLOCKS and "p" in self._open:
            self.faults.append(f"a block in a paragraph: {at}")
        if parent in CHILDREN and tag not in CHILDREN[parent]:
            self.faults.append(f"not allowed in {parent}: {at}")
        if tag == "html" and given.get("lang") != "en":
            self.faults.append(f"no language: {at}")
        if tag == "img" and not given.get("alt"):
            self.faults.append(f"no alternative text: {at}")
        if given.get("role") == "img" and not given.get("aria-label"):
            self.faults.append(f"no label: {at}")
        if tag in CONTROLS and "label" not in self._open and not given.get("aria-label"):
            self.faults.append(f"a control without a label: {at}")
        if tag in HEADINGS:
            self._read_heading(HEADINGS.index(tag) + 1, at)
        self._read_ids(given, at)
        self.tags.append(tag)
        if tag not in VOID:
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag in VOID or not self._open or self._open[-1] != tag:
            self.faults.append(f"</{tag}> in line {self.getpos()[0]} closes nothing: {self._open}")
        else:
            self._open.pop()

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "title":
            self._title += data
        if self._open and self._open[-1] in CHILDREN and data.strip():
            self.faults.append(f"text in {self._open[-1]}: {data.strip()}")

    def _read_heading(self, level: int, at: str) -> None:
        if level > self._level + 1:
            self.faults.append(f"a level of headings is left out: {at}")
        self._level = level

    def _read_ids(self, given: dict[str, str | None], at: str) -> None:
        name = given.get("id")
        if name is not None:
            if not name or name in self.ids:
                self.faults.append(f"id {name!r} is empty or not the only one: {at}")
            self.ids.add(name)
        for key in ("for", "aria-labelledby"):
            self._references += (given.get(key) or "").split()

    def _judge_the_whole(self) -> None:
        if self._open:
            self.faults.append(f"left open: {self._open}")
        if not self._title.strip():
            self.faults.append("no title")
        for tag in ("h1", "main", "header", "footer"):
            if self.tags.count(tag) != 1:
                self.faults.append(f"{self.tags.count(tag)} elements {tag}")
        self.faults += [f"nothing has the id {x!r}" for x in self._references if x not in self.ids]
