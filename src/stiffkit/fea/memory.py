"""How much memory a factorisation takes, and how much there is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from stiffkit.errors import CadError

_BLOCK = 72
"""bytes of a 3 x 3 block of doubles."""

_FILL = 4.4
"""Measured on parts and blocks: blocks in the factor over (nodes)^1.4, at the high end."""

_EXPONENT = 1.4

_MARGIN = 1.15
"""What a refined mesh may take beyond that law."""

_OVERHEAD = 1.5
"""Matrix, element data and work space beside the factor."""

SHARE = 0.8
"""Of the free memory that a solve may take."""


@dataclass(frozen=True)
class Fill:
    """What a factor was seen to take."""

    n_nodes: int
    blocks: float
    """Of 3 x 3 doubles."""


def direct_bytes(n_nodes: int, known: Fill | None = None) -> float:
    """Return a prediction of the bytes that a direct solve with ``n_nodes`` nodes takes.

    Where a smaller factor of such a mesh is ``known``, it is told from that.
    """
    fill = _FILL if known is None else _MARGIN * known.blocks / known.n_nodes**_EXPONENT
    return float(_OVERHEAD * _BLOCK * fill * n_nodes**_EXPONENT)


def must_iterate(
    n_nodes: int, solver: str, allowed: float | None, known: Fill | None = None
) -> bool:
    """Say whether to solve iteratively.

    ``solver``: direct, iterative, or auto; ``allowed`` in bytes, most of what is free if None;
    ``known``: see `direct_bytes`.
    Raises `CadError` if the direct solver is asked for and will not fit.
    """
    if solver == "iterative":
        return True
    if allowed is None:
        allowed = SHARE * free_bytes()
    needed = direct_bytes(n_nodes, known)
    if needed > allowed and solver == "direct":
        raise CadError(
            f"solving {3 * n_nodes} unknowns directly takes about {needed / 1e9:.1f} GB, "
            f"and {allowed / 1e9:.1f} GB are allowed",
            mend="use the iterative solver, a larger mesh size or a lower order",
        )
    return needed > allowed


def free_bytes() -> float:
    """Return how much memory is free for this process, inf where the system does not say."""
    return min(_system_free(), _container_free())


def _system_free() -> float:
    try:
        lines = Path("/proc/meminfo").read_text(encoding="ascii").splitlines()
    except OSError:
        return float("inf")
    for line in lines:
        if line.startswith("MemAvailable:"):
            return 1024.0 * float(line.split()[1])
    return float("inf")


def _container_free() -> float:
    """Return what the control group leaves, inf if it sets no limit."""
    group = Path("/sys/fs/cgroup")
    try:
        limit = (group / "memory.max").read_text(encoding="ascii").strip()
        used = float((group / "memory.current").read_text(encoding="ascii"))
    except (OSError, ValueError):
        return float("inf")
    return float("inf") if limit == "max" else max(0.0, float(limit) - used)
