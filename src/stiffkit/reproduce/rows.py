"""Rows of a paper's tables beside ours, where a row stands or falls as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from stiffkit.reproduce.printed import deviation, units_above


class Standing(Enum):
    """How a row of ours stands to the printed one."""

    FOLLOWS = "follows within the printed digits"
    DIFFERS = "differs"
    OTHER = "is of another part, for information"
    UNKNOWN = "cannot be computed from what is printed"


@dataclass(frozen=True)
class PrintedRow:
    """A printed row, ours, and what each rests on."""

    table: str
    row: str
    columns: tuple[str, ...]
    printed: tuple[str, ...]
    """As they are printed, without units and the table's powers of ten."""
    ours: tuple[float, ...] | None
    """In the same units; None where nothing printed leads to them."""
    unit: str
    known: str
    """What the paper prints that ours rests on."""
    assumed: str
    """What it does not print, and ours takes."""
    is_other: bool = False
    """Whether ours is of a part that the paper does not have."""
    why: str = ""
    """Why the two differ."""

    @property
    def standing(self) -> Standing:
        """How ours stands to the printed row."""
        if self.ours is None:
            return Standing.UNKNOWN
        if self.is_other:
            return Standing.OTHER
        pairs = zip(self.printed, self.ours, strict=True)
        # Rounded, or cut off, as some of the printed numbers are.
        follows = all(-0.5 <= units_above(text, x) < 1.0 for text, x in pairs)
        return Standing.FOLLOWS if follows else Standing.DIFFERS

    @property
    def deviation(self) -> float | None:
        """The largest difference of ours from the printed row, relative."""
        if self.ours is None:
            return None
        pairs = zip(self.printed, self.ours, strict=True)
        return max((abs(deviation(text, x)) for text, x in pairs), default=None)

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "table": self.table,
            "row": self.row,
            "columns": list(self.columns),
            "printed": list(self.printed),
            "ours": None if self.ours is None else list(self.ours),
            "unit": self.unit,
            "standing": self.standing.value,
            "deviation": self.deviation,
            "known": self.known or None,
            "assumed": self.assumed or None,
            "why": self.why or None,
        }
