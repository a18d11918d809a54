"""Identification of a compliance from a million nodes and six load cases, reading apart.

All is measured in a process of its own, so that its peak of memory is that of identification and
of the field itself.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict, dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.measure import peak_bytes, seconds
from stiffkit.identify import Field, identify

NODES = 100
"""Along each edge of the cube of nodes."""
SIZE = 0.01
REFERENCE = np.zeros(3)
WRENCHES = np.diag([100.0, 100.0, 100.0, 1.0, 1.0, 1.0])


@dataclass(frozen=True)
class Measured:
    """What one identification takes."""

    nodes: int
    seconds: float
    field_bytes: int
    """Of displacements."""
    sum_seconds: float
    """Of a plain sum over the displacements."""
    peak_bytes: int
    """Of the whole process, the field included."""

    @property
    def rate(self) -> float:
        """Bytes of displacements per second."""
        return self.field_bytes / self.seconds

    @property
    def sum_rate(self) -> float:
        """Bytes per second of the sum."""
        return self.field_bytes / self.sum_seconds


def made_field() -> Field:
    """Return a cube of nodes, displaced by six small rigid motions and noise."""
    step = np.linspace(-SIZE / 2, SIZE / 2, NODES)
    points = np.stack(np.meshgrid(step, step, step, indexing="ij"), axis=-1).reshape(-1, 3)
    displacements = np.random.default_rng(0).normal(scale=5e-8, size=(6, len(points), 3))
    for axis in range(3):
        displacements[axis, :, axis] += 1e-4
        turn = np.eye(3)[axis] * 1e-3
        displacements[axis + 3] += np.cross(turn, points)
    return Field(points, displacements)


def measure() -> Measured:
    """Return the times and the peak memory of a process of its own."""
    code = "from benchmarks.identify import print_measured; print_measured()"
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    return Measured(**json.loads(done.stdout))


def print_measured() -> None:
    """Measure in this process, and print the result as JSON."""
    field = made_field()
    u = field.displacements
    with threadpool_limits(1):
        identified = seconds(lambda: identify(field, WRENCHES, REFERENCE), 3)
        summed = seconds(u.sum)
    peak = peak_bytes()
    print(json.dumps(asdict(Measured(field.node_count, identified, u.nbytes, summed, peak))))
