"""Closing the loops of many geometries over their workspaces.

Each posture begins at the same relative place in the workspace of the anchor that is nearest, and
is reached from there in one piece or not at all. What is not is tried from its neighbours in the
same geometry, and from home, as a map does it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import over_blocks
from stiffkit.errors import AssemblyError
from stiffkit.kinematics import ClosureEquations, Kinematics, SpanningTree
from stiffkit.kinematics.coordinates import joint_coordinates, rotation_vectors
from stiffkit.kinematics.home import NEAR_HINTS, gaps, wraps
from stiffkit.kinematics.jump import jump
from stiffkit.kinematics.tracking import CLOSED
from stiffkit.robot import DIRECTIONS
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.family import Geometry
from stiffkit.study.sweep.group import Group
from stiffkit.study.sweep.reaching import THOROUGH, Care, Reaching

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_TOGETHER = 2048
"""Postures at a time: what is computed of them then stays in the cache."""

_STARTS = 32
_STEPS = 60
_LONGEST = 0.5
"""Longest step of Newton's method from a random start, rad or robot sizes."""
_SAME = 1e-6
"""Assemblies whose distances from the rough coordinates differ by less are the same."""


@dataclass(frozen=True, eq=False)
class Homes:
    """The home postures of G geometries."""

    unknowns: Array
    """(n_home, G)."""
    tool: Array
    """(6, G), tool poses."""
    reasons: list[str]
    """Why a geometry cannot be assembled, "" where it can."""
    continued: Mask
    """(G,), whether it is the assembly mode of the nearest anchor."""


class Closing:
    """Home postures and workspaces of geometries of one group."""

    def __init__(
        self,
        group: Group,
        geometries: Sequence[Geometry],
        anchors: Anchors,
        near: NDArray[np.intp],
        care: Care = THOROUGH,
    ) -> None:
        """Take G geometries, and which anchors (a, G) are the nearest of each, nearest first."""
        self.care = care
        self.group = group
        self.family = group.family
        self.geometries = geometries
        self.anchors = anchors
        self.near = near
        self.nearest = near[0]
        rows = slice(None, group.n_geometric)
        self.constants = np.stack([g.constants[rows] for g in geometries], axis=1)

    # --- home ---

    def homes(self) -> Homes:
        """Return the home posture of each geometry.

        That of the anchor is continued. It is taken if it is as near as it must be to the rough
        joint coordinates of the file, or if there is no assembly that is nearer; otherwise the
        geometry is put together by itself.
        """
        group, at = self.group, self.nearest
        asked = np.stack([g.home for g in self.geometries], axis=1)
        hints = np.stack([g.hints for g in self.geometries], axis=1)
        n = group.tree.n_coordinates
        start = self.anchors.home[:, at]
        moved = np.nan_to_num(hints - self.anchors.hints[:, at])
        start[:n] += moved[self._tree_rows()]
        step = group.home_step.at(self.constants, np.arange(at.size))
        q, reached = jump(step, start, asked, self.anchors.home_response[:, at])
        tool, joints = self.observe(q[:n], np.arange(at.size))
        off_by = self._off_by(joints - hints, np.arange(at.size))
        off_by[~reached] = np.inf
        doubtful = np.flatnonzero(off_by >= NEAR_HINTS)
        reasons = [""] * len(self.geometries)
        continued = np.ones(at.size, dtype=bool)
        if doubtful.size:
            least, found = self._nearest_assembly(doubtful, asked, hints)
            for i, distance, assembly in zip(doubtful, least, found.T, strict=True):
                if np.isinf(distance) and not reached[i]:
                    reasons[i] = "no assembly was found at the home posture"
                elif distance < off_by[i] - _SAME:
                    continued[i] = False
                    q[:, i], reasons[i] = self._checked(i, assembly, asked[:, i])
            tool[:, doubtful], _ = self.observe(q[:n, doubtful], doubtful)
        return Homes(q, tool, reasons, continued)

    def _nearest_assembly(
        self, which: NDArray[np.intp], asked: Array, hints: Array
    ) -> tuple[Array, Array]:
        """Return how far (G,) the assembly nearest to the rough coordinates is from them, and it.

        It (n_home, G) is looked for from many starts at once; the distance is infinite where none
        leads to an assembly.
        """
        closure, at = self.group.at_home, np.repeat(which, _STARTS + len(self.near))
        n = self.group.tree.n_coordinates
        q = np.concatenate([self._starts(i, hints[:, i]) for i in which], axis=1)
        step = self.group.home_step.at(self.constants, at)
        x = np.concatenate([q, asked[:, at]])
        with np.errstate(all="ignore"):
            for _ in range(_STEPS):
                out = step(x)
                share = np.minimum(1.0, _LONGEST / np.sqrt(out[closure.n_unknowns + 1]))
                x[: len(q)] += share * (out[: len(q)] - x[: len(q)])
            closed = np.sqrt(step(x)[closure.n_unknowns]) <= CLOSED
            _, joints = self.observe(x[:n], at)
        off_by = np.where(closed, self._off_by(joints - hints[:, at], at), np.inf)
        starts = at.size // which.size
        best = np.argmin(off_by.reshape(which.size, starts), axis=1)
        best += starts * np.arange(which.size)
        found = x[: len(q), best]
        turning = wraps(closure)
        found[turning] = (found[turning] + np.pi) % (2.0 * np.pi) - np.pi
        return off_by[best], found

    def _starts(self, i: int, hints: Array) -> Array:
        """Return the unknowns (n_home, s) to look for assemblies from: of anchors, and random."""
        closure, n = self.group.at_home, self.group.tree.n_coordinates
        # The same for every geometry, whatever others are looked at with it.
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (closure.n_unknowns, _STARTS))
        random *= np.where(closure.translates, self.geometries[i].length, np.pi)[:, None]
        given, away = hints[self._tree_rows(), None], np.linspace(0.0, 1.0, _STARTS)
        random[:n] = np.where(np.isnan(given), random[:n], given + away * random[:n])
        return np.concatenate([self.anchors.home[:, self.near[:, i]], random], axis=1)

    def _checked(self, i: int, assembly: Array, asked: Array) -> tuple[Array, str]:
        """Return the home posture of a geometry, given one that fulfils the equations.

        The equations hold as well with a joint's axes half a turn away; then the geometry is put
        together as if there were no other. The second value says why it cannot be.
        """
        geometry = self.geometries[i]
        given = self.family.given_at_home
        own = ClosureEquations(SpanningTree.of(geometry.robot), given, geometry.length)
        if not gaps(own, assembly, asked):
            return assembly, ""
        try:
            return Kinematics(geometry.robot).home_found.unknowns, ""
        except AssemblyError as error:
            return assembly, error.what

    def _tree_rows(self) -> NDArray[np.intp]:
        """Return where the tree's coordinates are among all joint coordinates."""
        starts, total = {}, 0
        for joint in self.group.tree.robot.joints.values():
            starts[joint.name] = total
            total += len(joint.motions)
        return np.array(
            [
                starts[t.joint.name] + i
                for t in self.group.tree.joints
                for i in range(len(t.joint.motions))
            ],
            dtype=np.intp,
        )

    def observe(self, q: Array, which: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return tool poses (6, N) and all joint coordinates, in the file's order, of postures."""
        tree = self.group.tree
        values = self.group.observe.at(self.constants, which)(q)
        frames = values.reshape(-1, 12, q.shape[1])
        R, p = frames[:, :9].reshape(len(frames), 3, 3, -1), frames[:, 9:]
        parts = {t.joint.name: q[t.coordinates] for t in tree.joints}
        for i, chord in enumerate(tree.chords, start=1):
            parts[chord.name] = joint_coordinates(chord, R[i], p[i])
        joints = np.concatenate([np.zeros((0, q.shape[1])), *(parts[j] for j in tree.robot.joints)])
        return np.concatenate([p[0], rotation_vectors(R[0])]), joints

    def _off_by(self, difference: Array, which: NDArray[np.intp]) -> Array:
        """Return the largest distance (N,) from the rough coordinates, rad or robot sizes."""
        motions = [m for joint in self.group.tree.robot.joints.values() for m in joint.motions]
        turns = np.array([m.startswith("r") for m in motions], dtype=bool)
        length = np.array([self.geometries[i].length for i in which])
        away = np.where(
            turns[:, None], (difference + np.pi) % (2.0 * np.pi) - np.pi, difference / length
        )
        # What the file does not give is NaN, and as near as can be.
        return np.asarray(np.max(np.nan_to_num(np.abs(away)), axis=0, initial=0.0))

    # --- workspace ---

    def postures(self, which: NDArray[np.intp], homes: Homes) -> tuple[Array, Mask]:
        """Return the postures (n, G, P) of some of the geometries, and which are reached (G, P)."""
        asked = self.asked(which, homes)
        inside = np.stack([self.geometries[i].inside for i in which])
        q = np.empty((self.group.closure.n_unknowns, *inside.shape))
        reached = np.zeros(inside.shape, dtype=bool)
        size = max(1, _TOGETHER // self.family.n_postures)
        for start in range(0, which.size, size):
            part = slice(start, start + size)
            q[:, part], found = self._jump(which[part], asked[:, part], homes)
            reached[part] = found & inside[part]
        if (inside & ~reached).any():
            constants = self.constants[:, which]
            reaching = Reaching(self.group, self.family.neighbours, constants, asked, self.care)
            home_q, home_pose = self.home(which, homes)
            reaching.find(q, reached, inside, home_q, home_pose)
        q[:, ~reached] = np.nan
        return q, reached

    def _jump(self, which: NDArray[np.intp], asked: Array, homes: Homes) -> tuple[Array, Mask]:
        at = self.nearest[which]
        start = self.anchors.q[:, at]
        start[:, ~homes.continued[which]] = np.nan
        n, shape = len(start), asked.shape[1:]
        q, poses, response = (
            A.reshape(len(A), -1) for A in (start, asked, self.anchors.response[:, at])
        )
        number = np.repeat(np.arange(which.size), self.family.n_postures)
        constants, step = self.constants[:, which], self.group.step.compiled()
        known = np.flatnonzero(np.isfinite(q).all(axis=0))
        reached = np.zeros(number.size, dtype=bool)

        def work(block: slice) -> None:
            own = known[block]
            own_step = step.at(constants, number[own])
            q[:, own], reached[own] = jump(own_step, q[:, own], poses[:, own], response[:, own])

        over_blocks(known.size, _TOGETHER, work)
        return q.reshape(n, *shape), reached.reshape(shape)

    def asked(self, which: NDArray[np.intp], homes: Homes) -> Array:
        """Return the tool coordinates (m, G, P) that are asked for."""
        P = self.family.n_postures
        rows = []
        for d in self.family.asked:
            if d in self.family.swept:
                row = self.family.swept.index(d)
                rows.append(np.stack([self.geometries[i].poses[row] for i in which]))
            else:
                tool = homes.tool[DIRECTIONS.index(d), which]
                rows.append(np.repeat(tool[:, None], P, axis=1))
        return np.array(rows).reshape(len(rows), which.size, P)

    def home(self, which: NDArray[np.intp], homes: Homes) -> tuple[Array, Array]:
        """Return unknowns (n, G) and tool coordinates asked for (m, G) at home."""
        n = self.group.tree.n_coordinates
        tool = homes.tool[:, which]
        extra = [DIRECTIONS.index(d) for d in self.group.closure.auxiliary]
        pose = [DIRECTIONS.index(d) for d in self.family.asked]
        return np.concatenate([homes.unknowns[:n, which], tool[extra]]), tool[pose]
