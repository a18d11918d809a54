"""What a paper says in words, beside what comes out here."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Any


class Outcome(Enum):
    """Whether what a paper says comes out."""

    AGREES = "agrees"
    PARTLY = "agrees in part"
    DIFFERS = "differs"
    UNKNOWN = "cannot be compared"

    @staticmethod
    def of(*conditions: bool) -> Outcome:
        """Return how much of what is said holds: all of it, some, or nothing."""
        if all(conditions):
            return Outcome.AGREES
        return Outcome.PARTLY if any(conditions) else Outcome.DIFFERS


@dataclass(frozen=True)
class Statement:
    """A sentence of a paper, and what was found."""

    where: str
    """Section or figure."""
    printed: str
    """What the paper says."""
    ours: str
    """What comes out here, with its numbers."""
    outcome: Outcome
    why: str = ""
    """Why the two differ, or what is not printed."""

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "where": self.where,
            "printed": self.printed,
            "ours": self.ours,
            "verdict": self.outcome.value,
            "why": self.why or None,
        }
