"""What a robot is: links, joints, tool, workspace, loads; plain numbers in SI units.

The loader makes these objects from a robot file, and everything above reads only them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.link import Line, Superelement
from stiffkit.spatial import Frame

if TYPE_CHECKING:
    from stiffkit.fea import CadLink

Array = NDArray[np.float64]

BASE = "base"
"""Name of the body that stands still."""

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""The six directions of a joint frame, and the six coordinates of the tool pose."""


class Freedom(Enum):
    """What one direction of a joint does under load."""

    PASSIVE = "passive"
    BLOCKED = "blocked"
    DRIVEN = "driven"
    ELASTIC = "elastic"


@dataclass(frozen=True, eq=False)
class Link:
    """A body with ports.

    The port "base" is at the link's origin. The compliance of an elastic link is that of its other
    ports, each at its origin, with the base clamped, in the axes of the link frame.
    """

    name: str
    ports: Mapping[str, Frame]
    """T_link_port of each port; "base" first."""
    compliance: Array | None = None
    """(6(m-1), 6(m-1)), SI, positive definite, of m ports; None for a rigid link."""
    mass: float | None = None
    """kg."""
    center_of_mass: Array | None = None
    """(3,), m, link frame."""
    inertia: Array | None = None
    """3x3, kg m^2, about the centre of mass, axes of the link frame."""
    origin: str = "rigid"
    """How the link was given: rigid, beam, compliance, the name of a link file, or the CAD file."""
    line: Line | None = None
    """Elasticity and mass along the link, where they are known: those of a beam."""
    superelement: Superelement | None = None
    """Mass and modes of the link, where somebody reduced it already; its mass is this one's."""
    content_hash: str = ""
    """SHA-256 of the link file, where there is one."""
    covariance: Array | None = None
    """(36, 36), SI, of the elements of the compliance row by row, where it was identified."""
    cad: CadLink | None = None
    """The part that the link is, with its interfaces and solution, where it was given by CAD."""

    @property
    def other_ports(self) -> tuple[str, ...]:
        """The ports but the base, in the order of the compliance."""
        return tuple(name for name in self.ports if name != BASE)


@dataclass(frozen=True, eq=False)
class Joint:
    """A connection between two bodies.

    At zero coordinates the joint frames on both sides coincide. Coordinates move the ``to`` side
    in the joint frame of the ``from`` side.
    """

    name: str
    kind: str
    """fixed, revolute, prismatic, universal, spherical, cylindrical or planar."""
    axes: tuple[str, ...]
    """Axes ("x", "y", "z") of the joint frame; one for revolute, prismatic, cylindrical and planar
    (its normal), two for universal (first on the ``from`` side), none for fixed and spherical."""
    from_body: str
    T_from_joint: Frame
    """Joint frame in the frame of the ``from`` body."""
    to_body: str
    T_to_joint: Frame
    """Joint frame in the frame of the ``to`` body."""
    freedoms: tuple[Freedom, ...]
    """Six, one for each of `DIRECTIONS`, in the joint frame."""
    stiffness: Array
    """(6,), N/m and N m/rad, of driven and elastic directions; inf where a drive is rigid, and 0
    where the direction is passive, inf where it is blocked."""
    from_port: str = "base"
    """Port of the ``from`` body that the joint is attached to."""
    to_port: str = "base"
    """Port of the ``to`` body that the joint is attached to."""

    @property
    def motions(self) -> tuple[str, ...]:
        """The directions in which the joint moves, in the order of its coordinates.

        A universal joint turns about its first, then about its second axis; the three rotations
        of a spherical joint are the components of one rotation vector.
        """
        match self.kind:
            case "fixed":
                return ()
            case "revolute":
                return ("r" + self.axes[0],)
            case "prismatic":
                return (self.axes[0],)
            case "cylindrical":
                return (self.axes[0], "r" + self.axes[0])
            case "universal":
                return ("r" + self.axes[0], "r" + self.axes[1])
            case "spherical":
                return ("rx", "ry", "rz")
            case "planar":
                u, v = (axis for axis in "xyz" if axis != self.axes[0])
                return (u, v, "r" + self.axes[0])
        raise ValueError(f"unknown joint kind {self.kind!r}")


@dataclass(frozen=True, eq=False)
class Tool:
    """The tool frame, where loads act and deflections are read."""

    body: str
    T_body_tool: Frame
    mass: float | None = None
    """kg, a point mass at the tool point."""
    port: str = "base"
    """Port of the body that the tool is attached to."""


@dataclass(frozen=True, eq=False)
class Home:
    """The home posture, which fixes the assembly mode, as far as the file gives it."""

    tool: Mapping[str, float] = field(default_factory=dict)
    """Tool coordinates (of `DIRECTIONS`), m and rad: these are met exactly."""
    joints: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    """Rough joint coordinates, m and rad, one for each motion of the joint: the nearest assembly
    is taken."""


@dataclass(frozen=True, eq=False)
class Load:
    """A wrench on the tool at the tool point, world axes."""

    name: str
    wrench: Array
    """(6,), N and N m."""


@dataclass(frozen=True, eq=False)
class Workspace:
    """Where the tool goes: a box, cut by a polygon if there is one, or a list of points."""

    ranges: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    """Lowest and highest value of tool coordinates, m and rad."""
    counts: Mapping[str, int] = field(default_factory=dict)
    """Number of grid points along a coordinate, where the file asks for one."""
    polygon: Array | None = None
    """(n, 2), m: corners of an outline over the coordinates `polygon_axes`."""
    polygon_axes: tuple[str, str] = ("x", "y")
    points: Array | None = None
    """(n, len(point_axes)), m and rad; instead of ranges."""
    point_axes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Parameter:
    """A named number of the robot file."""

    name: str
    value: float
    """SI."""
    unit: str
    """The unit it was written with, "" for a bare number."""


@dataclass(frozen=True, eq=False)
class Robot:
    """A mechanism with its tool, its workspace and its load cases."""

    name: str
    """Short name: the file's stem."""
    title: str
    links: Mapping[str, Link]
    joints: Mapping[str, Joint]
    tool: Tool
    home: Home
    workspace: Workspace
    loads: Mapping[str, Load]
    parameters: Mapping[str, Parameter]
    source: Path | None = None
    content_hash: str = ""
    """SHA-256 of the robot file."""
    lines: Mapping[str, int] = field(default_factory=dict)
    """Lines of the robot file, from 1, at which its sections begin."""
    notes: tuple[str, ...] = ()
    """Repairs that the file asked for, and other things a reader should know."""
