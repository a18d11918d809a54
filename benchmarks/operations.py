"""Counting the floating-point operations of a compiled kernel.

heyoka breaks a kernel down into a list of elementary steps, in which what occurs several times
stands once; that list is what is compiled. Each addition, subtraction, multiplication, division and
square root in it counts as one operation. Sines, cosines and their inverses are counted apart: each
of them is some twenty to forty operations of the machine, so rates that leave them out are lower
bounds. Comparisons, selections and changes of sign are not counted.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import Any

_FUNCTIONS = ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")


@dataclass(frozen=True)
class Operations:
    """The operations of a kernel for one posture."""

    arithmetic: int
    """Additions, multiplications, divisions and square roots."""
    functions: int
    """Sines, cosines and inverses."""
    divisions: int
    """Of the arithmetic: divisions and square roots, which take several times as long."""


def operations(function: Any) -> Operations:
    """Return the operations of a heyoka cfunc. Raises ValueError for a step of unknown kind."""
    steps = [str(step) for step in function.dc[function.nvars : len(function.dc) - function.nouts]]
    kinds: Counter[str] = Counter()
    for step in steps:
        kind, count = _kind(step)
        kinds[kind] += count
    divisions = kinds["division"]
    return Operations(kinds["arithmetic"] + divisions, kinds["function"], divisions)


def _kind(step: str) -> tuple[str, int]:
    named = re.match(r"(?:combined_)?([a-z_]+[0-9]?)\(", step)
    if named:
        return _of_name(named[1], step)
    power = re.fullmatch(r".+\*\*(-?[0-9.]+)", step)
    if power:
        return _of_power(float(power[1]), step)
    if re.fullmatch(r"\(.+ (<|<=|>|>=|==|!=) .+\)", step):
        return "free", 0
    inner = re.findall(r" ([+*]) ", step)
    if inner:
        return "arithmetic", len(inner)
    if step.startswith("-"):
        return "free", 0
    raise ValueError(f"the step '{step}' is of a kind that cannot be counted")


def _of_name(name: str, step: str) -> tuple[str, int]:
    if name in _FUNCTIONS:
        return "function", 1
    if name == "sub":
        return "arithmetic", 1
    if name in ("div", "sqrt"):
        return "division", 1
    if name == "square":
        return "arithmetic", 1
    if name in ("prod", "sum"):
        return "arithmetic", step.count(",")
    if name == "sum_sq":
        return "arithmetic", 2 * step.count(",") + 1
    if name == "select":
        return "free", 0
    raise ValueError(f"the step '{step}' is of a kind that cannot be counted")


def _of_power(exponent: float, step: str) -> tuple[str, int]:
    if exponent in (-1.0, 0.5):
        return "division", 1
    if exponent == -0.5:
        return "division", 2
    whole = abs(int(exponent))
    if exponent != int(exponent) or whole > 8:
        raise ValueError(f"the power in '{step}' cannot be counted")
    multiplications = whole.bit_length() - 1 + bin(whole).count("1") - 1
    return ("arithmetic", multiplications) if exponent > 0 else ("division", multiplications + 1)
