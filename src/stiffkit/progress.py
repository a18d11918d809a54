"""How what takes long tells how far it is."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Takes what is being done, in words, and the share of the whole that is done, from 0 to 1."""


def no_progress(what: str, share: float) -> None:
    """Tell nobody."""
    del what, share
