"""Rigid ports, and rigid-body motions between ports."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import CadError
from stiffkit.fea.interfaces import Port
from stiffkit.spatial.rotation import Array
from stiffkit.spatial.twist import twist_shift


def check_apart(on_port: Mapping[str, NDArray[np.bool_]]) -> None:
    """Raise `CadError` if rigid ports touch, by which nodes (n,) are on each of them."""
    for a, b in itertools.combinations(on_port, 2):
        if (on_port[a] & on_port[b]).any():
            raise CadError(
                f"interfaces {a} and {b} are rigid and touch each other: they overlap along an "
                "edge",
                mend="make one of them average, or choose faces that lie apart",
            )


def relative_twists(ports: Sequence[Port], ref: int) -> Array:
    """Return B (6(m-1), 6m): twists of all ports to those of the others relative to ``ref``."""
    m = len(ports)
    others = [i for i in range(m) if i != ref]
    B = np.zeros((6 * (m - 1), 6 * m))
    for at, i in enumerate(others):
        B[6 * at : 6 * at + 6, 6 * i : 6 * i + 6] = np.eye(6)
        B[6 * at : 6 * at + 6, 6 * ref : 6 * ref + 6] = -twist_shift(
            ports[i].point - ports[ref].point
        )
    return B


def rehold(k: Array, ports: Sequence[Port], old: int, new: int) -> Array:
    """Return the compliance with port ``new`` held, from that with ``old`` held."""
    m = len(ports)
    others = [i for i in range(m) if i != old]
    full = np.zeros((6 * m, 6 * m))
    rows = np.concatenate([6 * i + np.arange(6) for i in others])
    full[np.ix_(rows, rows)] = k
    B = relative_twists(ports, new)
    out = B @ full @ B.T
    return np.asarray(0.5 * (out + out.T))
