"""Printed numbers: how far ours is from what stands in a paper, in its own digits."""

from __future__ import annotations

from decimal import Decimal


def units_above(printed: str, ours: float) -> float:
    """Return how many units of the last printed digit ours is above the printed number."""
    digit = 10.0 ** int(Decimal(printed).as_tuple().exponent)
    return (ours - float(printed)) / digit


def deviation(printed: str, ours: float) -> float:
    """Return ours from the printed number, relative to it."""
    return ours / float(printed) - 1.0
