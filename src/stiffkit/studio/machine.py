"""A robot whose every parameter can be moved, and that answers at once."""

from __future__ import annotations

import math
import threading
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import default_backend
from stiffkit.errors import StiffkitError
from stiffkit.files.names import suggest
from stiffkit.kinematics import typical_length
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import DIRECTIONS, RobotFile
from stiffkit.stiffness import Model
from stiffkit.studio.frequencies import Frequencies
from stiffkit.studio.kernels import SharedKernels
from stiffkit.studio.sliders import Slider, in_si, sliders_of
from stiffkit.studio.stations import Closed, Stations
from stiffkit.studio.variant import Variant
from stiffkit.studio.view import PoseView
from stiffkit.study.frequencies import has_mass
from stiffkit.study.map import MODELS
from stiffkit.study.quantities import QUANTITIES
from stiffkit.study.sweep.family import Family, Geometry
from stiffkit.study.sweep.spec import StudySpec, Varied

__all__ = ["Machine", "PoseView", "Slider", "Variant"]

Array = NDArray[np.float64]

_MOST_KEPT = 8
"""Variants that are remembered."""
_SLOW_POINTS = 600
"""Postures where a model has no kernel and each takes a millisecond or more."""
_FREQUENCY_POSTURES = 12
_LITTLE = 0.01
"""How much parameters are moved to see what depends on them, over the range of their slider."""


class Machine:
    """A robot of a file, or of the catalogue, as something to play with.

    It may be used by several threads, one at a time. All numbers are SI.
    """

    def __init__(
        self, source: str | Path, *, points: int = 10_000, progress: Progress = no_progress
    ) -> None:
        """Read a robot, put it together and make its machine code, which takes a few seconds.

        ``points`` is about how many poses of the workspace are looked at; there are fewer where a
        model can only be computed one posture at a time. Raises FileError, AssemblyError or
        PoseError where there can be no such robot.
        """
        progress("reading the robot", 0.0)
        file = RobotFile(source)
        robot = file.robot(progress=progress)
        sliders = sliders_of(file, robot, typical_length(robot))
        live = [slider for slider in sliders.values() if slider.live]
        progress("putting it together", 0.1)
        self._family = family = _family(source, live, points)
        self.robot = robot
        """The robot of the file."""
        self.parameters: Mapping[str, Slider] = {n: s for n, s in sliders.items() if not s.follows}
        """What can be moved: parameters with a value of their own."""
        self.following: Mapping[str, Slider] = {n: s for n, s in sliders.items() if s.follows}
        """Parameters that follow from others; `variant` takes values of them too."""
        self.models: tuple[Model, ...] = MODELS
        self.loads: tuple[str, ...] = tuple(robot.loads)
        self.swept: tuple[str, ...] = family.swept
        """The tool coordinates of the workspace."""
        self.asked: tuple[str, ...] = family.asked
        """The tool coordinates that fix a posture; the others follow."""
        self.shape: tuple[int, ...] = family.grid.shape
        """Of the poses of the workspace, see `Variant.shape`."""
        self.is_grid = not family.grid.listed
        self.vibrates = has_mass(robot)
        """Whether anything has mass."""
        self.quantities: tuple[str, ...] = tuple(
            name
            for name, quantity in QUANTITIES.items()
            if (self.loads or not quantity.per_load)
            and (self.vibrates or quantity.source != "frequencies")
        )
        """Names of the quantities that a variant has."""
        self._lock = threading.RLock()
        self._kept: OrderedDict[tuple[tuple[str, float], ...], Variant] = OrderedDict()
        self._workspaces: OrderedDict[bytes, Closed] = OrderedDict()
        progress("closing its loops", 0.3)
        backend = default_backend()
        self._groups = SharedKernels(family, backend, _ordinary(family, live))
        own = self._loops(family.geometry(family.own_values()))
        self._stations = Stations(self._groups, [s for s in live if self._moves(s, own)])
        self.frequencies = Frequencies(self._groups, self._stations, backend)
        self._warm_up(progress)
        progress("done", 1.0)

    @property
    def home(self) -> dict[str, float]:
        """The tool coordinates `asked`, where the robot file has them at home."""
        tool = self._family.kinematics.home.tool[:, 0]
        return {d: float(tool[DIRECTIONS.index(d)]) for d in self.asked}

    def variant(self, values: Mapping[str, float] | None = None) -> Variant:
        """Return the robot with other values (SI) of some of its parameters.

        A variant depends on these values and not on which ones there were before. Raises
        StiffkitError where there can be no such robot; the machine can be used after that as
        before.
        """
        given = self._checked(values or {})
        key = tuple(sorted(given.items()))
        with self._lock:
            if key not in self._kept:
                self._kept[key] = Variant(self, given, self._closed(given))
                while len(self._kept) > _MOST_KEPT:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(key)
            return self._kept[key]

    def uncontrolled(self, model: Model) -> bool:
        """Tell whether a model's tool can move freely at ordinary postures."""
        return self._family.analysis.model(model).uncontrolled

    def check_dependent(self, pose: Mapping[str, float], tool: Array) -> None:
        """Check tool coordinates that were asked for against the pose (6,) that was reached.

        Raises PoseError for one that follows from the others and has another value.
        """
        self._family.kinematics.check_dependent(pose, tool)

    def _checked(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return those of the values that are not the file's own."""
        given = {}
        for name, value in values.items():
            if name not in self.robot.parameters:
                raise StiffkitError(
                    f"{self.robot.name} has no parameter '{name}'",
                    mend=suggest(name, self.robot.parameters),
                )
            if not math.isfinite(value):
                raise StiffkitError(
                    f"the parameter {name} cannot be {value}", mend="give it a finite value"
                )
            if name in self.following or value != self.parameters[name].value:
                given[name] = float(value)
        return given

    def _geometry(self, values: Mapping[str, float]) -> Geometry:
        family = self._family
        given = {
            name: in_si(value, self.robot.parameters[name].unit) for name, value in values.items()
        }
        with np.errstate(all="ignore"):
            return family.geometry_of(family.file.robot(given))

    def _closed(self, values: Mapping[str, float]) -> Closed:
        """Return a variant's workspace; that of one before if it differs in stiffness only."""
        geometry = self._geometry(values)
        key = self._loops(geometry)
        if key not in self._workspaces:
            self._workspaces[key] = self._stations.closed(geometry, values)
            while len(self._workspaces) > _MOST_KEPT:
                self._workspaces.popitem(last=False)
        self._workspaces.move_to_end(key)
        return replace(self._workspaces[key], geometry=geometry)

    def _loops(self, geometry: Geometry) -> bytes:
        """Return all numbers that the postures of a geometry follow from."""
        geometric = geometry.constants[: self._groups.of(geometry).n_geometric]
        parts = (geometric, geometry.home, geometry.hints, geometry.poses, geometry.inside)
        return b"".join(part.tobytes() for part in parts)

    def _moves(self, slider: Slider, own: bytes) -> bool:
        """Tell whether a parameter moves loops, and does not change stiffnesses only."""
        beside = slider.value + _LITTLE * (slider.high - slider.low)
        try:
            return self._loops(self._geometry({slider.name: beside})) != own
        except StiffkitError:
            return True

    def _warm_up(self, progress: Progress) -> None:
        """Have everything compiled that a slider or the tool would otherwise wait for."""
        own = self.variant()
        for i, model in enumerate(self.models):
            progress(f"machine code of the {model} model", 0.5 + 0.2 * i)
            own.status(model)
        progress("looking at the home posture", 0.9)
        view = own.at(self.home)
        for model in self.models:
            view.result(model)


def _family(source: str | Path, live: Sequence[Slider], points: int) -> Family:
    """Return the family of all variants, with fewer postures where each takes its time."""
    varied = tuple(Varied(one.name, (one.low, one.high), one.unit) for one in live)

    def family(postures: int) -> Family:
        return Family(
            StudySpec(
                title="",
                robot=str(source),
                varied=varied,
                sample=None,
                seed=0,
                postures=postures,
                models=MODELS,
                frequency_postures=_FREQUENCY_POSTURES,
                columns=(),
            )
        )

    found = family(points)
    slow = any(found.analysis.model(model).method == "assembly" for model in MODELS)
    return family(_SLOW_POINTS) if slow and found.n_postures > _SLOW_POINTS else found


def _ordinary(family: Family, live: Sequence[Slider]) -> Geometry:
    """Return a geometry without zeros and right angles by chance; the own one if there is none."""
    own = family.own_values()
    shares = _LITTLE * (0.1 + np.modf(0.618034 * np.arange(1, own.size + 1))[0])
    ranges = np.array([one.high - one.low for one in live])
    try:
        return family.geometry(own + shares * ranges)
    except StiffkitError:
        return family.geometry(own)
