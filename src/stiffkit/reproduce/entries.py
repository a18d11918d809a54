"""One number of a paper beside ours."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any

from stiffkit.reproduce.printed import deviation, units_above


class Verdict(Enum):
    """What the comparison of a printed number with ours says."""

    AGREES = "agrees within the printed digits"
    BELOW = "below the printed error"
    DIFFERS = "differs"


@dataclass(frozen=True)
class Entry:
    """A printed number, ours, and what to think of them."""

    where: str
    """Table or section, and which entry."""
    printed: str
    """As it is printed, without its unit."""
    ours: float
    unit: str
    is_bound: bool = False
    """Whether the printed number is an error of rounding, which ours must not exceed."""
    why: str = ""
    """Why the two differ, where that is known."""
    converged: float | None = None
    """What a solution without the error of the mesh gives, where there is one."""

    @property
    def verdict(self) -> Verdict:
        """Whether ours, rounded to the printed digits, is the printed number."""
        if self.is_bound:
            return Verdict.BELOW if self.ours <= float(self.printed) else Verdict.DIFFERS
        agrees = abs(units_above(self.printed, self.ours)) <= 0.5 * (1.0 + 1e-9)
        return Verdict.AGREES if agrees else Verdict.DIFFERS

    @property
    def deviation(self) -> float:
        """Ours from the printed number, relative to it."""
        return deviation(self.printed, self.ours)

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "where": self.where,
            "printed": self.printed,
            "ours": self.ours,
            "converged": self.converged,
            "unit": self.unit,
            "deviation": self.deviation,
            "verdict": self.verdict.value,
            "why": self.why or None,
        }
