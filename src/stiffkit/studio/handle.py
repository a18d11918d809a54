"""The handle at the tool, by which it is drawn through the workspace."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.robot import DIRECTIONS
from stiffkit.spatial import exp_rotation, log_rotation

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]


class Handle:
    """Arrows and arcs at the tool, for the tool coordinates that can be asked for."""

    def __init__(
        self,
        server: viser.ViserServer,
        asked: Sequence[str],
        size: float,
        moved: Callable[[Mapping[str, float]], None],
    ) -> None:
        """Take names of coordinates, the handle's ``size`` (m), and who is told of new values."""
        self._asked = tuple(asked)
        self._turns = any(name.startswith("r") for name in asked)
        self._is_held = False
        self._at = np.full(6, np.nan)
        along = tuple(name in asked for name in "xyz")
        self._controls = server.scene.add_transform_controls(
            "/tool",
            scale=size,
            active_axes=(along[0], along[1], along[2]),
            disable_axes=not any(along),
            disable_sliders=not any(along),
            disable_rotations=not self._turns,
            depth_test=False,
            opacity=0.85,
        )

        # On the event loop, so that positions are taken in the order in which they came.
        @self._controls.on_update
        async def _(event: viser.TransformControlsEvent) -> None:
            self._is_held = event.phase != "end"
            moved(self._pose())
            if not self._is_held:
                self._settle()

    def place(self, tool: Array) -> None:
        """Put the handle at a tool pose (6,), unless somebody holds it."""
        self._at = tool
        if not self._is_held:
            self._settle()

    def _settle(self) -> None:
        if np.isfinite(self._at).all():
            self._controls.position = self._at[:3]
            if self._turns:
                self._controls.wxyz = _quaternion(exp_rotation(self._at[3:]))

    def _pose(self) -> dict[str, float]:
        """Return the coordinates that are asked for where the handle is now, m and rad."""
        tool = self._at.copy()
        tool[:3] = self._controls.position
        if self._turns:
            tool[3:] = log_rotation(_rotation(np.asarray(self._controls.wxyz, dtype=np.float64)))
        return {name: float(tool[DIRECTIONS.index(name)]) for name in self._asked}


def _rotation(wxyz: Array) -> Array:
    import viser.transforms as tf

    return np.asarray(tf.SO3(wxyz).as_matrix())


def _quaternion(R: Array) -> Array:
    import viser.transforms as tf

    return np.asarray(tf.SO3.from_matrix(R).wxyz)
