"""A displacement field: where nodes are, and how far each load case moves them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiffkit.errors import FieldError
from stiffkit.identify.spread import Spread, require_rotations_seen
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False, init=False)
class Field:
    """Nodes near a reference point and their displacements in m load cases, all in SI.

    Nodes of zero weight are dropped on construction; `nodes` says which are left.
    """

    points: Array
    """(n, 3), m, where the nodes are before the load acts."""
    displacements: Array
    """(m, n, 3), m, how far each load case moves each node."""
    weights: Array
    """(n,), positive: how much each node counts, such as its share of a face's area."""
    case_names: tuple[str, ...]
    """m names of the load cases."""
    nodes: NDArray[np.int64]
    """(n,), labels of the nodes: those given, or their place (from 0) in what was given."""

    def __init__(
        self,
        points: ArrayLike,
        displacements: ArrayLike,
        weights: ArrayLike | None = None,
        case_names: Sequence[str] | None = None,
        nodes: ArrayLike | None = None,
    ) -> None:
        """Check and keep a field; weights are equal and cases numbered from 1 if not given.

        Raises `FieldError` where numbers are missing or not finite, where shapes do not match, and
        where the nodes lie in one point or on one line, so that a rotation cannot be seen.
        """
        p = np.ascontiguousarray(points, dtype=float)
        u = np.ascontiguousarray(displacements, dtype=float)
        _check_shapes(p, u)
        count, cases = len(p), len(u)
        names = _checked_names(case_names, cases)
        w = np.ones(count) if weights is None else np.ascontiguousarray(weights, dtype=float)
        labels = np.arange(count) if nodes is None else np.asarray(nodes, dtype=np.int64)
        if labels.shape != (count,):
            raise FieldError(f"there are {count} nodes and {len(labels)} node labels")
        kept = _checked_weights(w, labels)
        if not kept.all():
            p, u, w, labels = p[kept], u[:, kept], w[kept], labels[kept]
        _check_finite(p, u, names, labels)
        for name, value in (
            ("points", p),
            ("displacements", u),
            ("weights", w),
            ("case_names", names),
            ("nodes", labels),
        ):
            object.__setattr__(self, name, value)
        require_rotations_seen(self.spread)

    @property
    def node_count(self) -> int:
        """n, nodes that have weight."""
        return len(self.points)

    @property
    def case_count(self) -> int:
        """m, load cases."""
        return len(self.displacements)

    @cached_property
    def relative_weights(self) -> Array:
        """(n,), the weights scaled to a mean of 1."""
        return np.asarray(self.weights * (self.node_count / self.weights.sum()))

    @cached_property
    def spread(self) -> Spread:
        """Centre, principal axes and extents of the weighted nodes."""
        return Spread.of(self.points, self.relative_weights)

    def case(self, index: int, kept: NDArray[np.bool_] | None = None) -> Field:
        """Return the field of one load case, of all nodes or of those in the mask (n,)."""
        chosen = slice(None) if kept is None else kept
        return Field(
            self.points[chosen],
            self.displacements[index : index + 1, chosen],
            self.weights[chosen],
            self.case_names[index : index + 1],
            self.nodes[chosen],
        )


def _check_shapes(p: Array, u: Array) -> None:
    if p.ndim != 2 or p.shape[1] != 3:
        raise FieldError(f"points must have the shape (n, 3) and have {p.shape}")
    if u.ndim != 3 or u.shape[2] != 3:
        raise FieldError(
            f"displacements must have the shape (cases, n, 3) and have {u.shape}",
            mend="stack the load cases along the first axis, also when there is only one",
        )
    if u.shape[1] != len(p):
        raise FieldError(
            f"there are {len(p)} points and displacements of {u.shape[1]} nodes",
            mend="give the displacements of the same nodes, in the same order, as the points",
        )
    if len(p) == 0:
        raise FieldError(
            "the field has no nodes", mend="select nodes around the reference point, at least 3"
        )
    if len(u) == 0:
        raise FieldError("the field has no load case")


def _checked_names(names: Sequence[str] | None, cases: int) -> tuple[str, ...]:
    if names is None:
        return tuple(str(i + 1) for i in range(cases))
    if len(names) != cases:
        raise FieldError(f"there are {cases} load cases and {len(names)} names of them")
    return tuple(names)


def _checked_weights(w: Array, labels: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Return which nodes have weight (n,)."""
    if w.shape != labels.shape:
        raise FieldError(f"there are {len(labels)} nodes and weights of shape {w.shape}")
    bad: NDArray[np.bool_] = np.asarray(~np.isfinite(w) | (w < 0.0))
    if bad.any():
        i = int(np.argmax(bad))
        raise FieldError(
            f"the weight of node {labels[i]} is {w[i]:g}{_others(bad)}",
            mend="weights are zero or positive, such as the node's share of the face's area",
        )
    kept = w > 0.0
    if not kept.any():
        raise FieldError("all nodes have the weight zero", mend="give at least 3 nodes weight")
    return np.asarray(kept)


def _check_finite(p: Array, u: Array, names: tuple[str, ...], labels: NDArray[np.int64]) -> None:
    bad = np.logical_not(np.isfinite(p).all(axis=1))
    if bad.any():
        i = int(np.argmax(bad))
        raise FieldError(f"the point of node {labels[i]} is {_triple(p[i])}{_others(bad)}")
    for name, displacement in zip(names, u, strict=True):
        finite = np.isfinite(displacement)
        if finite.all():
            continue
        bad = np.logical_not(finite.all(axis=1))
        i = int(np.argmax(bad))
        raise FieldError(
            f"load case {name}: the displacement of node {labels[i]} is "
            f"{_triple(displacement[i])}{_others(bad)}",
            mend="leave such nodes out, or give them the weight zero",
        )


def _others(bad: NDArray[np.bool_]) -> str:
    more = int(bad.sum()) - 1
    return f", and {more} more nodes are like it" if more else ""


def _triple(values: Array) -> str:
    return "({:g}, {:g}, {:g})".format(*values)
