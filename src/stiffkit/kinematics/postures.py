"""Tool poses to postures, for any mechanism: the room's main door."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, BatchFunction, over_blocks
from stiffkit.errors import PoseError
from stiffkit.kinematics.closure import ClosureEquations
from stiffkit.kinematics.coordinates import joint_coordinates, rotation_vectors
from stiffkit.kinematics.home import assemble
from stiffkit.kinematics.mobility import Mobility, controllable
from stiffkit.kinematics.tracking import BLOCK, STEPS, Tracker
from stiffkit.kinematics.tree import SpanningTree
from stiffkit.robot import DIRECTIONS, Robot

Array = NDArray[np.float64]


class Status(IntEnum):
    """What is known of a posture."""

    OK = 0
    UNREACHABLE = 1
    SINGULAR = 2
    UNCONTROLLED = 3
    OUTSIDE = 4

    @property
    def word(self) -> str:
        """The name as files and tables show it."""
        return self.name.lower()


@dataclass(frozen=True, eq=False)
class Postures:
    """A batch of N postures."""

    coordinates: Array
    """(n, N), coordinates of the spanning tree, m and rad; NaN where unreachable."""
    tool: Array
    """(6, N): x, y, z, rotation vector; world axes; m and rad."""
    joints: Array
    """(n_joint_coordinates, N), in the order of `Kinematics.joint_names`."""
    reached: NDArray[np.bool_]
    """(N,)."""

    def __len__(self) -> int:
        """Return N."""
        return int(self.coordinates.shape[1])

    def part(self, which: slice) -> Postures:
        """Return some of the postures."""
        return Postures(
            self.coordinates[:, which],
            self.tool[:, which],
            self.joints[:, which],
            self.reached[which],
        )


class Kinematics:
    """The rigid motion of a robot: its home posture, and any other."""

    def __init__(
        self, robot: Robot, *, prefer: Iterable[str] = (), backend: Backend | None = None
    ) -> None:
        """Put the robot together at home.

        ``prefer`` names tool coordinates that shall be independent if the mechanism allows it.
        Raises AssemblyError if loops cannot be closed at home.
        """
        self.robot = robot
        self.backend = backend
        self.tree = SpanningTree.of(robot)
        self.length = typical_length(robot)
        given = [d for d in DIRECTIONS if d in robot.home.tool]
        at_home = ClosureEquations(self.tree, given, self.length)
        self.home_found = assemble(at_home)
        self._home = self.home_found.unknowns[: self.tree.n_coordinates]
        wanted = dict.fromkeys(
            [*prefer, *robot.workspace.ranges, *robot.workspace.point_axes, *given, *DIRECTIONS]
        )
        self.asked = tuple(
            d for d in DIRECTIONS if d in controllable(self.loops, self._home, list(wanted))
        )
        """Tool coordinates that fix a posture; the others follow from the mechanism."""

    @cached_property
    def loops(self) -> ClosureEquations:
        """The closure equations without any tool coordinates."""
        return ClosureEquations(self.tree, (), self.length)

    @cached_property
    def closure(self) -> ClosureEquations:
        """The closure equations for the tool coordinates `asked`."""
        return ClosureEquations(self.tree, self.asked, self.length)

    @cached_property
    def mobility(self) -> Mobility:
        """Degrees of freedom at home."""
        return Mobility.of(self.loops, self._home)

    @cached_property
    def _observe(self) -> BatchFunction:
        return BatchFunction(self.loops.observation(), self.backend)

    @cached_property
    def _newton_step(self) -> BatchFunction:
        return BatchFunction(self.closure.newton_step(), self.backend)

    def _tracker(self, n: int) -> Tracker:
        """Return what follows the assembly mode to ``n`` poses."""
        turns = np.array([d.startswith("r") for d in self.asked], dtype=bool)
        return Tracker(self._newton_step.ready_for(STEPS * n), self.closure.n_unknowns, turns)

    @cached_property
    def joint_names(self) -> list[str]:
        """Names such as "motor_left.rz" of all joint coordinates, joints in the file's order."""
        return [f"{j.name}.{motion}" for j in self.robot.joints.values() for motion in j.motions]

    @cached_property
    def home(self) -> Postures:
        """The home posture, a batch of one."""
        return self.observe(self._home[:, None])

    def observe(self, coordinates: Array) -> Postures:
        """Return the postures at coordinates (n, N) of the tree, which must close the loops."""
        n = coordinates.shape[1]
        reached = np.empty(n, dtype=bool)
        tool, joints = np.empty((6, n)), np.empty((len(self.joint_names), n))
        evaluate = self._observe.ready_for(n)

        def work(block: slice) -> None:
            q = coordinates[:, block]
            reached[block] = known = np.isfinite(q).all(axis=0)
            self._read(evaluate(q), q, tool[:, block], joints[:, block])
            if not known.all():
                # What is the same in all postures would have a value even where there is none.
                tool[:, block][:, ~known] = np.nan
                joints[:, block][:, ~known] = np.nan

        over_blocks(n, BLOCK, work)
        return Postures(coordinates, tool, joints, reached)

    def _read(self, values: Array, q: Array, tool: Array, joints: Array) -> None:
        """Fill in tool pose and joint coordinates from what the kernel of observation gives."""
        frames = values.reshape(values.shape[0] // 12, 12, q.shape[1])
        R = frames[:, :9].reshape(len(frames), 3, 3, q.shape[1])
        p = frames[:, 9:]
        tool[:3], tool[3:] = p[0], rotation_vectors(R[0])
        parts = {t.joint.name: q[t.coordinates] for t in self.tree.joints}
        for i, chord in enumerate(self.tree.chords, start=1):
            parts[chord.name] = joint_coordinates(chord, R[i], p[i])
        start = 0
        for part in (parts[name] for name in self.robot.joints):
            joints[start : start + len(part)] = part
            start += len(part)

    def solve(
        self, asked: Array, wanted: NDArray[np.bool_] | None = None, *, detours: bool = True
    ) -> Postures:
        """Return the postures at tool coordinates (m, N) in the order of `asked`, SI.

        The assembly mode of the home posture is followed; what it cannot reach is NaN, and so is
        what is not ``wanted`` (N,). Without ``detours`` only ways between these postures are tried,
        which is quicker where some are out of reach.
        """
        closure = self.closure
        home_tool = self.home.tool[:, 0]
        home = np.array([home_tool[DIRECTIONS.index(d)] for d in self.asked])
        extra = [home_tool[DIRECTIONS.index(d)] for d in closure.auxiliary]
        q_home = np.concatenate([self._home, extra])
        span = np.array([1.0 if d.startswith("r") else self.length for d in self.asked])
        asked = np.asarray(asked, dtype=float)
        everywhere = wanted is None or bool(wanted.all())
        poses = asked if everywhere else asked[:, wanted]
        tracker = self._tracker(poses.shape[1])
        around = self._tracker if detours else None
        q, _ = tracker.spread(q_home[:, None], home, poses, span, around)
        if not everywhere:
            found = q
            q = np.full((closure.n_unknowns, asked.shape[1]), np.nan)
            q[:, wanted] = found
        return self.observe(q[: self.tree.n_coordinates])

    def solve_at(self, at: Mapping[str, float]) -> Postures:
        """Return the posture (a batch of one) at named tool coordinates, SI.

        Independent coordinates that are not given are the home posture's. Raises PoseError for a
        coordinate that does not exist, or that follows from the others and has another value.
        """
        check_names(at)
        home = self.home.tool[:, 0]
        asked = [at.get(d, home[DIRECTIONS.index(d)]) for d in self.asked]
        postures = self.solve(np.array(asked)[:, None])
        if postures.reached[0]:
            self.check_dependent(at, postures.tool[:, 0])
        return postures

    def check_dependent(self, at: Mapping[str, float], tool: Array) -> None:
        """Check tool coordinates that were asked for against the pose (6,) that was reached.

        Raises PoseError for one that follows from the others and has another value.
        """
        for name, wanted in at.items():
            if name in self.asked:
                continue
            actual = float(tool[DIRECTIONS.index(name)])
            scale = 1.0 if name.startswith("r") else self.length
            if abs(actual - wanted) > 1e-6 * scale:
                unit = "rad" if name.startswith("r") else "m"
                independent = ", ".join(self.asked) or "none"
                raise PoseError(
                    f"the tool cannot have {name} = {wanted:.6g} {unit} there: the mechanism"
                    f" makes it {actual:.6g} {unit}",
                    mend=f"leave {name} out; the independent tool coordinates of"
                    f" {self.robot.name} are: {independent}",
                )


def check_names(at: Mapping[str, float]) -> None:
    """Raise PoseError for a tool coordinate that does not exist."""
    for name in at:
        if name not in DIRECTIONS:
            raise PoseError(
                f"'{name}' is no tool coordinate",
                mend=f"the tool coordinates are {', '.join(DIRECTIONS)}",
            )


def typical_length(robot: Robot) -> float:
    """Return a length (m) that is typical of the robot: its largest offset between frames."""
    offsets = [float(np.linalg.norm(robot.tool.T_body_tool.position))]
    for joint in robot.joints.values():
        frames = (joint.T_from_joint, joint.T_to_joint)
        offsets += [float(np.linalg.norm(frame.position)) for frame in frames]
    offsets += [abs(value) for d, value in robot.home.tool.items() if not d.startswith("r")]
    return max(offsets) or 1.0
