"""Figures inside a page: sharp in print, small, and as wide as all others of their kind."""

from __future__ import annotations

import base64
import re
from html import escape
from pathlib import Path
from urllib.parse import quote

from stiffkit.errors import OutputError

_FONTS = ("'DejaVu Sans'", "'DejaVu Sans', Verdana, sans-serif")
"""What drawings ask for, and where that is not installed a font of the same widths."""

_MM = {"pt": 25.4 / 72.0, "in": 25.4, "mm": 1.0}

_DECIMALS = 2
"""Of coordinates in points: a hundredth is finer than any printer's dot."""

_ABOUT = re.compile(r"<metadata>.*?</metadata>", re.DOTALL)
_PATH = re.compile(r'(?<= d=")[^"]*(?=")')
_PLACE = re.compile(r'(?<= [xy]=")-?\d+\.\d+(?=")')
_IN_PATH = re.compile(r"[A-Za-z]|-?\d+(?:\.\d+)?(?:e-?\d+)?")

_UNQUOTED = "!$'()*+,-./:;=?@_~"
"""What a data address may hold as it is, besides letters and digits."""


def is_drawing(path: Path) -> bool:
    """Return whether a file is a figure's drawing; beside it there may be its picture (PNG)."""
    return path.suffix.lower() == ".svg"


def figure(drawing: Path, *, caption: str = "") -> str:
    """Return a figure as HTML: its drawing (SVG), or the picture (PNG) beside it if that is less.

    Raises OutputError if the drawing cannot be read.
    """
    source, width = _drawing(drawing)
    picture = drawing.with_suffix(".png")
    if picture.is_file():
        other = _picture(picture)
        source = min(source, other, key=len)
    words = escape(re.sub(r"[-_]+", " ", drawing.stem).strip())
    size = f' style="--width: {width:.4g}mm"' if width else ""
    below = f"<figcaption>{escape(caption)}</figcaption>" if caption else ""
    return f'<figure><img alt="{words}" src="{source}"{size}>{below}</figure>'


def _drawing(path: Path) -> tuple[str, float]:
    """Return the data address of a drawing, and its width in mm, 0 if it tells none."""
    text = _read(path).decode("utf-8").replace(*_FONTS)
    size = re.search(r'<svg\b[^>]*? width="([\d.]+)(pt|in|mm)"', text)
    text = _ABOUT.sub("", text[max(text.find("<svg"), 0) :])
    address = quote(" ".join(_rounded(text).split()), safe=_UNQUOTED)
    # Whoever looks for addresses in a page shall find none, not even of a namespace.
    address = address.replace("http:", "http%3A")
    return escape(f"data:image/svg+xml,{address}"), float(size[1]) * _MM[size[2]] if size else 0.0


def _picture(path: Path) -> str:
    return f"data:image/png;base64,{base64.b64encode(_read(path)).decode('ascii')}"


def _rounded(drawing: str) -> str:
    """Return a drawing with the coordinates of its lines rounded, and no more space than needed."""
    drawing = _PATH.sub(lambda found: _path(found[0]), drawing)
    return _PLACE.sub(lambda found: _short(found[0]), drawing)


def _path(commands: str) -> str:
    out = ""
    for word in _IN_PATH.findall(commands):
        follows_number = out[-1:].isdigit() and not word[0].isalpha()
        number = word if word[0].isalpha() else _short(word)
        out += f",{number}" if follows_number and number[0] != "-" else number
    return out


def _short(number: str) -> str:
    text = f"{float(number):.{_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise OutputError(
            f"cannot read the figure {path}: {error.strerror or error}",
            mend="write the figures first, give their paths as they were returned, and let nothing "
            "else write into their folder",
        ) from error
