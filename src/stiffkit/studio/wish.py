"""What the person at the page wants to see: one plain value, whole at any time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from stiffkit.stiffness import Model

REST = "at rest"
LOADED = "under the load"

ALL = "all poses"
SLICE = "one slice"
NOTHING = "nothing"
EXTENTS = (ALL, SLICE, NOTHING)


@dataclass(frozen=True)
class Wish:
    """Everything that can be chosen on the page. Numbers are SI."""

    values: Mapping[str, float]
    """Of parameters that differ from the file's, by name."""
    pose: Mapping[str, float]
    """The tool coordinates that can be asked for, m and rad."""
    load: str | None
    """A load case, None where the robot has none."""
    model: Model
    quantity: str
    extent: str = ALL
    """How much of the workspace is shown, one of `EXTENTS`."""
    slice_axis: str = ""
    slice_share: float = 0.5
    """Where the slice is, from 0 to 1 along its axis."""
    holds_scale: bool = False
    """Whether the colours keep their meaning while parameters change."""
    shape: str = REST
    """REST, LOADED, or a mode's number from 1."""
    magnification: float = 1.0
    """Of the suggested magnification of displacements; 0 is true to scale."""
    is_playing: bool = False
    is_faint: bool = False
    """Whether one can see through the mechanism."""
    ellipsoids: frozenset[str] = field(default_factory=frozenset)
    """Of translation, rotation."""
