"""Names in messages: where something stands, and what was probably meant."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from stiffkit.units import shorten

Key = str | int


def key_path(keys: Iterable[Key]) -> str:
    """Return a path of keys as text, such as ``links.arm.beam.section.tube[0]``."""
    text = "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in keys)
    return shorten(text.removeprefix("."), 120)


def suggest(name: str, known: Iterable[str]) -> str:
    """Return "did you mean ...?" with the nearest known names, or what there is."""
    names = list(known)
    other_case = [one for one in names if one.casefold() == name.casefold()]
    close = other_case or difflib.get_close_matches(name, names, n=2, cutoff=0.6)
    if close:
        return "did you mean " + " or ".join(f"'{one}'" for one in close) + "?"
    return "known here: " + shorten(", ".join(names), 100) if names else ""
