"""The studio at work: what was wished for last becomes what is seen.

One thread computes. It begins with the newest wish, colours first, and turns to a newer one as soon
as there is one; the last wish is always carried out to its end. What has not changed since it was
last shown is left as it is.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import OutputError, StiffkitError
from stiffkit.plots import position_text
from stiffkit.progress import Progress
from stiffkit.stiffness import PrincipalAxes
from stiffkit.studio.controls import Actions, Controls
from stiffkit.studio.drawn import Drawn, anatomy_of, draw
from stiffkit.studio.ellipsoid import ellipsoid
from stiffkit.studio.handle import Handle
from stiffkit.studio.latest import Latest
from stiffkit.studio.looks import ROTATION, TRANSLATION, look_of
from stiffkit.studio.machine import Machine
from stiffkit.studio.mapped import HeldScale, Mapped, map_of
from stiffkit.studio.motion import Motion
from stiffkit.studio.readout import Readout
from stiffkit.studio.saving import Bar, Saver
from stiffkit.studio.scene import Scene
from stiffkit.studio.variant import Variant
from stiffkit.studio.view import PoseView
from stiffkit.studio.wish import LOADED, NOTHING, REST, Wish
from stiffkit.study import QUANTITIES, PoseResult

if TYPE_CHECKING:
    import viser

Array = NDArray[np.float64]

_VIEW = "view"
_HANDLE = 0.16
"""Size of the tool's handle, over the robot's."""
_HALF_AXES = {"translation": 0.14, "rotation": 0.08}
"""Half the longest axes of ellipsoids at home, over the robot's size; one is inside the other."""
_PICTURE = (1000, 1600)
"""Height and width of a saved picture, pixels."""
_PATIENCE_S = 30.0


class Session:
    """One robot on one server; all browsers that look at it see the same."""

    def __init__(
        self,
        machine: Machine,
        server: viser.ViserServer,
        saver: Saver,
        values: Mapping[str, float],
    ) -> None:
        """Show the robot with ``values`` (SI) of some of its parameters.

        Raises StiffkitError where there can be no such robot.
        """
        self.machine = machine
        self._server = server
        self._saver = saver
        self._variant = machine.variant(values)
        self._anatomy = anatomy_of(self._variant)
        self._view: PoseView | None = None
        self._map: Mapped | None = None
        self._held: HeldScale | None = None
        self._drawn: Drawn | None = None
        self._pinned: PoseView | None = None
        self._asking = threading.Lock()
        self._drawing = threading.Lock()
        self._saving = threading.Lock()
        self._scene = Scene(server, self._variant)
        self._readout = Readout(server)
        self._latest = Latest(self._failed)
        self._controls = Controls(
            server,
            machine,
            Actions(
                wish_changed=self.refresh,
                go_home=lambda: self._go_to(self._variant.home),
                go_to_worst=self._go_to_worst,
                pin=self._pin,
                unpin=self._unpin,
                save_robot=self._save_robot,
                save_picture=self._save_picture,
                save_report=self._save_report,
            ),
        )
        self._controls.show_values(values)
        self._controls.show_pose(self._variant.home)
        size = _HANDLE * self._variant.size
        self._handle = Handle(server, machine.asked, size, self._go_to)
        self._readout.show_key(machine, {look_of(solid) for solid in self._anatomy.solids})
        home = self._variant.at(self._variant.home)
        self._scene.look_at(self._anatomy.vertices(home.q), self._variant)
        self._motion = Motion(self._draw_moment)
        self.refresh()

    @property
    def n_poses(self) -> int:
        """How many poses of the workspace are looked at."""
        return int(np.count_nonzero(self._variant.inside))

    def close(self) -> None:
        """End all threads."""
        self._motion.close()
        self._latest.close()

    def refresh(self) -> None:
        """Take what is set now as the newest wish."""
        began = time.perf_counter()
        # What is set is read and handed on in one go: events come on several threads.
        with self._asking:
            try:
                wish = self._controls.wish()
            except (KeyError, ValueError) as error:
                # A page sent what no control of ours can be set to.
                self._failed(error)
                return
            self._latest.submit(_VIEW, lambda: self._carry_out(wish, began))

    # --- carrying a wish out ----------------------------------------------------------------------

    def _carry_out(self, wish: Wish, began: float) -> None:
        self._motion.play(False)
        self._show_variant(wish)
        troubles = []
        for stage in (self._show_map, self._show_posture, self._show_numbers):
            try:
                stage(wish)
            except StiffkitError as error:
                # What cannot be shown leaves the rest to be seen.
                troubles.append(str(error))
            if self._latest.is_pending(_VIEW):
                return
        self._motion.play(wish.is_playing and wish.shape != REST)
        if self._view is not None and not self._view.reached:
            troubles.append("this pose is not reached; drawn is the nearest of the workspace")
        took = 1e3 * (time.perf_counter() - began)
        done = f"up to date: {self.n_poses:,} poses, computed in {took:.0f} ms"
        self._readout.say("\n".join(dict.fromkeys(troubles)) or done, is_bad=bool(troubles))

    def _failed(self, error: Exception) -> None:
        if isinstance(error, StiffkitError):
            self._readout.say(f"{error}\nShown is what was there before.", is_bad=True)
        else:
            self._readout.say(f"an error of the studio itself: {error!r}", is_bad=True)

    def _show_variant(self, wish: Wish) -> None:
        before = self._variant.values
        moved = {n for n in {*wish.values, *before} if wish.values.get(n) != before.get(n)}
        if any(self.machine.parameters[name].solves_parts for name in moved):
            self._readout.say("solving parts from CAD anew, which takes its time ...")
        variant = self.machine.variant(wish.values)
        if variant is not self._variant:
            self._anatomy = anatomy_of(variant)
            self._variant = variant

    def _show_map(self, wish: Wish) -> None:
        if QUANTITIES[wish.quantity].source == "frequencies":
            self._readout.say("natural frequencies over the workspace ...")
        held = self._held if wish.holds_scale else None
        try:
            shown = map_of(self._variant, wish, held)
        except StiffkitError:
            self._map = None
            self._scene.hide_map()
            self._readout.hide_map()
            raise
        self._held = HeldScale(wish.quantity, shown.scale, shown.unit)
        self._map = shown
        self._scene.show_map(self._variant, shown, wish)
        self._readout.show_map(self._variant, shown, wish)

    def _show_posture(self, wish: Wish) -> None:
        variant = self._variant
        view = self._view
        if view is None or view.variant is not variant or dict(view.asked) != dict(wish.pose):
            view = self._view = variant.at(wish.pose)
        drawn_at = view if view.reached else variant.at(_nearest(variant, wish.pose))
        result = drawn_at.result(wish.model)
        at = drawn_at.tool[:3]
        self._handle.place(drawn_at.tool)
        force = None if wish.load is None else variant.robot.loads[wish.load].wrench[:3]
        self._scene.show_load(at, force if wish.shape == LOADED else None)
        self._show_ellipsoids(wish, result, at)
        try:
            self._draw(draw(self._anatomy, drawn_at, wish, variant.size))
        except StiffkitError:
            at_rest = replace(wish, shape=REST)
            self._draw(draw(self._anatomy, drawn_at, at_rest, variant.size))
            raise

    def _draw(self, drawn: Drawn) -> None:
        with self._drawing:
            self._drawn = drawn
            self._scene.show_mechanism(drawn.solids, drawn.bent(), is_faint=drawn.is_faint)
            if drawn.moved is None:
                self._scene.hide("/rest")
            else:
                self._scene.show_rest(drawn.solids, drawn.rest)

    def _show_ellipsoids(self, wish: Wish, result: PoseResult, at: Array) -> None:
        for name, colour in (("translation", TRANSLATION), ("rotation", ROTATION)):
            axes: PrincipalAxes | None = getattr(result, name)
            if axes is None or name not in wish.ellipsoids:
                self._scene.hide(f"/ellipsoids/{name}")
                continue
            # As long as at home if as stiff, so that it grows where the robot is stiffer.
            at_home = self._variant.at(self._variant.home).result(wish.model)
            reference = _strongest(getattr(at_home, name)) or _strongest(axes) or 1.0
            drawn = ellipsoid(axes, reference, _HALF_AXES[name] * self._variant.size)
            self._scene.show_ellipsoid(name, drawn.mesh, at, colour)

    def _show_numbers(self, wish: Wish) -> None:
        view = self._view
        if view is None:
            return
        views = [view] if self._pinned is None else [view, self._pinned]
        results = [one.result(wish.model) for one in views]
        magnification = 1.0 if self._drawn is None else self._drawn.magnification
        frequencies: list[Array] = []
        try:
            frequencies = [self._frequencies(one) for one in views]
        finally:
            self._readout.show_pose(results, frequencies, wish, magnification)

    def _frequencies(self, view: PoseView) -> Array:
        """Return the lowest natural frequencies of a pose. Raises LinkError for wrong masses."""
        modes = view.modes() if self.machine.vibrates else None
        return np.empty(0) if modes is None else modes.frequencies_hz

    def _draw_moment(self, share: float) -> None:
        with self._drawing:
            if self._drawn is not None and self._drawn.moved is not None:
                bent = self._drawn.bent(share)
                self._scene.show_mechanism(self._drawn.solids, bent, is_faint=self._drawn.is_faint)

    # --- what is done at the page -----------------------------------------------------------------

    def _go_to(self, pose: Mapping[str, float]) -> None:
        self._controls.show_pose(pose)
        self.refresh()

    def _go_to_worst(self) -> None:
        if self._map is not None and self._map.worst is not None:
            worst = self._variant.poses[:, self._map.worst[0]]
            swept = dict(zip(self._variant.swept, map(float, worst), strict=True))
            self._go_to({**self._variant.home, **swept})

    def _pin(self) -> None:
        if self._view is not None and self._drawn is not None:
            self._pinned = self._view
            self._scene.show_pinned(self._drawn.solids, self._drawn.rest)
            self.refresh()

    def _unpin(self) -> None:
        self._pinned = None
        self._scene.hide("/pinned")
        self.refresh()

    # --- saving -----------------------------------------------------------------------------------

    def _save_robot(self, client: viser.ClientHandle | None) -> None:
        del client
        values = self._variant.values
        self._save("the robot file", lambda name, _: self._saver.robot_file(name, values))

    def _save_picture(self, client: viser.ClientHandle | None) -> None:
        def write(name: str, _: Progress) -> Path:
            # What is seen, and what is said of it, belong together once nothing is left to do.
            self._latest.wait(_PATIENCE_S)
            return self._saver.picture(name, self._seen_by(client), self._caption(), self._bar())

        self._save("the picture", write)

    def _save_report(self, client: viser.ClientHandle | None) -> None:
        del client
        robot = self._variant.robot
        self._save("the report", lambda name, tell: self._saver.report(name, robot, tell))

    def _save(self, what: str, write: Callable[[str, Progress], Path]) -> None:
        """Write something under the name on the page, and tell about it there."""
        tell = self._controls.tell_saved
        if not self._saving.acquire(blocking=False):
            tell("something is being saved just now; try again when that is done")
            return
        try:
            tell(f"writing {what} ...")
            path = write(self._controls.name, lambda doing, _: tell(f"{what}: {doing} ..."))
            tell(f"saved {path.relative_to(self._saver.folder)} in {self._saver.folder}")
        except StiffkitError as error:
            tell(str(error))
        finally:
            self._saving.release()

    def _seen_by(self, client: viser.ClientHandle | None) -> NDArray[np.uint8]:
        if client is None:
            raise OutputError("the page that asked for the picture is gone", mend="try again")
        try:
            return client.get_render(*_PICTURE, transport_format="png", timeout=_PATIENCE_S)
        except (RuntimeError, TimeoutError) as error:
            raise OutputError(f"the browser gave no picture: {error}", mend="try again") from None

    def _caption(self) -> str:
        if self._view is None:
            return self._variant.robot.title
        return f"{self._variant.robot.title}\n{position_text(self._view.asked.items())}"

    def _bar(self) -> Bar | None:
        wish, shown = self._controls.wish(), self._map
        if shown is None or wish.extent == NOTHING:
            return None
        quantity = QUANTITIES[wish.quantity]
        of_load = f", load {wish.load}" if quantity.per_load else ""
        label = f"{quantity.label}{of_load}, {wish.model} model"
        return Bar(shown.scale, shown.unit.label(label))


def _strongest(axes: PrincipalAxes | None) -> float:
    """Return the largest finite principal stiffness, 0 if there is none."""
    if axes is None:
        return 0.0
    return float(np.max(axes.stiffness[np.isfinite(axes.stiffness)], initial=0.0))


def _nearest(variant: Variant, pose: Mapping[str, float]) -> dict[str, float]:
    """Return the nearest pose of the workspace that is reached, home if none is."""
    at = np.flatnonzero(variant.reached)
    if not at.size:
        return variant.home
    asked = np.array([pose.get(d, variant.home.get(d, 0.0)) for d in variant.swept])
    poses = variant.poses[:, at]
    spans = np.maximum(np.ptp(poses, axis=1), 1e-12)
    apart = np.sum(((poses - asked[:, None]) / spans[:, None]) ** 2, axis=0)
    nearest = poses[:, int(np.argmin(apart))]
    return {**variant.home, **dict(zip(variant.swept, map(float, nearest), strict=True))}
