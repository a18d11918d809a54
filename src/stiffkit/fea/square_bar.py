"""A square bar, the part that textbooks and papers compute."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from stiffkit.fea.geometry import MM, Part, build_part


def square_bar(length: float, width: float) -> Part:
    """Return a bar of square section along x, sizes in m, with the end faces base and tip."""
    return build_part(Path(__file__), "shape", {"length": length / MM, "width": width / MM})


def shape(length: float, width: float) -> Any:
    """Return the bar's shape, mm; run in the process of the CAD kernel."""
    from netgen.occ import Box, X

    box = Box((0, 0, 0), (length, width, width))
    box.faces.Min(X).name = "base"
    box.faces.Max(X).name = "tip"
    return box
