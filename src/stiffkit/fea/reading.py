"""How rigidly the faces of a port move: their field through `identify`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from stiffkit.errors import FieldError
from stiffkit.fea.fields import CASES, face_field
from stiffkit.fea.superelement import PortModel
from stiffkit.identify import Identified, Options, identify
from stiffkit.spatial.frame import Frame
from stiffkit.spatial.rotation import Array

NOMINAL = (
    "what the rigid motion leaves is the deformation of the faces themselves and no noise: "
    "standard errors and significance are nominal, they are no confidence intervals; how far the "
    "compliance is from the exact one is told by the estimated error of the solution"
)
RIGID = "the faces move as one rigid body, as they are made to"


@dataclass(frozen=True, eq=False)
class FaceReading:
    """The compliance that `identify` finds in the field of a port's faces, and what it leaves."""

    found: Identified
    """At the port's point, in the axes of the field; loads of 1 N and 1 N m."""
    shares: Array
    """(6,), root mean square of the residuals over that of the displacements, of each load."""
    difference: float
    """Largest difference from the solution's own compliance, over the diagonal."""
    is_rigid: bool
    """Whether the port's faces are held in shape, so that what is left is rounding."""

    def describe(self) -> dict[str, Any]:
        """Return the statistics as plain values, SI, for each unit load."""
        found = self.found
        return {
            "points": found.node_count,
            "difference": self.difference,
            "rigid": self.is_rigid,
            "loads": {name: self._load(j) for j, name in enumerate(CASES)},
            "standard_error": found.standard_error.tolist(),
            "significant": found.significant.tolist(),
            "meaning": RIGID if self.is_rigid else NOMINAL if found.structured else "",
        }

    def _load(self, j: int) -> dict[str, Any]:
        estimate, shape = self.found.estimate, self.found.structure[j]
        return {
            "sigma": float(estimate.sigma[j]),
            "largest": float(estimate.largest[j]),
            "share": float(self.shares[j]),
            "structured": shape.structured and not self.is_rigid,
            "residuals": RIGID if self.is_rigid else shape.words,
        }


def read_faces(model: PortModel, port: int, frame: Frame | None = None) -> FaceReading:
    """Identify the compliance of a port from the field of its faces, each weighing its area.

    Axes are those of ``frame`` (``T_part_frame``; the part's if None). Each load has a sigma of its
    own: pooled, it would depend on the unit of length. Raises `FieldError` where the faces are too
    thin to tell a rotation from.
    """
    frame = frame or Frame()
    field = face_field(model, port, frame)
    at = frame.inverse.point(model.ports[port].point)
    found = identify(field, np.eye(6), at, Options(pooled=False))
    own = _own_compliance(model, port, frame)
    scale = np.sqrt(np.outer(np.diag(own), np.diag(own)))
    moved = np.sqrt(np.square(field.displacements).sum(axis=2) @ field.relative_weights)
    left = np.sqrt(field.node_count) * np.array([case.rms for case in found.structure])
    difference = float(np.abs((found.compliance - own) / scale).max())
    return FaceReading(found, left / moved, difference, model.ports[port].is_rigid)


def describe_readings(model: PortModel, frame: Frame) -> dict[str, Any]:
    """Return the statistics of all ports that are not held, by name, in the axes of ``frame``.

    Ports whose faces are too thin to tell a rotation from are left out.
    """
    readings = {}
    for i, port in enumerate(model.ports):
        if i == model.held:
            continue
        try:
            readings[port.name] = read_faces(model, i, frame).describe()
        except FieldError:
            continue
    return readings


def _own_compliance(model: PortModel, port: int, frame: Frame) -> Array:
    """Return the compliance (6, 6) of a port in the axes of a frame, as the solution has it."""
    others = [i for i in range(len(model.ports)) if i != model.held]
    at = 6 * others.index(port) + np.arange(6)
    turn = np.kron(np.eye(2), frame.rotation)
    return np.asarray(turn.T @ model.compliance[np.ix_(at, at)] @ turn)
