"""A robot with everything that is computed once: kinematics and stiffness models."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend
from stiffkit.errors import AssemblyError
from stiffkit.kinematics import Kinematics
from stiffkit.robot import Robot, with_place
from stiffkit.stiffness import FreeMotion, Model, Stiffness, describe_free_motion

Array = NDArray[np.float64]


class Analysis:
    """What poses, maps and checks of one robot share."""

    def __init__(
        self, robot: Robot, *, prefer: Iterable[str] = (), backend: Backend | None = None
    ) -> None:
        """Put the robot together at home; see `stiffkit.kinematics.Kinematics`."""
        self.robot = robot
        try:
            self.kinematics = Kinematics(robot, prefer=prefer, backend=backend)
        except AssemblyError as error:
            raise with_place(error, robot, "home") from None
        self._backend = backend

    @cached_property
    def refined(self) -> Stiffness:
        """The refined model."""
        return Stiffness(self.kinematics, "refined", backend=self._backend)

    @cached_property
    def simplified(self) -> Stiffness:
        """The simplified model."""
        return Stiffness(self.kinematics, "simplified", backend=self._backend)

    def model(self, name: Model) -> Stiffness:
        """Return a model by its name."""
        return self.refined if name == "refined" else self.simplified

    def words(self, motion: FreeMotion, tool: Array) -> str:
        """Return a free motion in words, at a tool pose (6,)."""
        return describe_free_motion(motion, tool, self.kinematics.length)
