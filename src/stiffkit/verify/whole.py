"""A whole robot at a posture as one sparse system, and its solution."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import block_array, coo_array, csr_array

from stiffkit.errors import CadError
from stiffkit.fea.factor import Factor
from stiffkit.kinematics.numeric import null_space
from stiffkit.robot import BASE, Freedom, Joint, Robot
from stiffkit.spatial import Frame, twist_shift
from stiffkit.spatial.rotation import Array
from stiffkit.verify.body import Body
from stiffkit.verify.places import Places

_WEAK = 1e-10
"""Stiffness of the springs that make the matrix definite, over what a node is held with."""

_SOFT = 1e-4
"""Compliance that does so at the joints, times what a node is held with."""

_EXACT = 1e-12
"""Relative error that a solution is corrected to, if nothing else is asked for."""

_GOOD = 1e-7
"""The correction that must be reached where rounding does not let it become smaller."""

_MOST_CORRECTIONS = 60


@dataclass(frozen=True, eq=False)
class _Ties:
    """The directions in which joints hold: ``rows x`` is what they yield."""

    rows: csr_array
    """(m, n), of the coordinates of all bodies; m or rad."""
    compliance: Array
    """(m,), m/N or rad/(N m); 0 where a direction is blocked."""
    turns: NDArray[np.bool_]
    """(m,), whether a direction is a rotation."""


class Whole:
    """All bodies of a robot, tied by its joints, at one posture.

    The unknowns are the coordinates x (n,) of all bodies, one body after the other, and the forces
    f (m,) in the directions that joints hold:

        K x + C^T f = loads,    C x - c f = 0

    with c = 0 where a joint blocks and 1/k where a drive or a bearing yields. A direction that is
    passive has no row.
    """

    def __init__(
        self, robot: Robot, bodies: Mapping[str, Body], frames: Mapping[str, Frame], places: Places
    ) -> None:
        """Take bodies by the names of links, and the frames ``T_world_body`` of their axes."""
        self.robot = robot
        self.bodies = bodies
        self.frames = frames
        self.places = places
        self._reach = max(float(np.linalg.norm(f.position)) for f in frames.values()) or 1.0
        ends = np.cumsum([0, *(body.size for body in bodies.values())])
        self._at = {name: slice(a, b) for name, a, b in zip(bodies, ends, ends[1:], strict=False)}
        self.n_coordinates = int(ends[-1])
        self._ties = self._tie()
        self._tool = self._port_rows(robot.tool.body, robot.tool.port, places.tool.position)
        self.free_motions = self._find_free_motions()
        """(n, k), coordinates of motions that nothing holds, such as a rod's spin."""
        self._free = np.linalg.qr(self.free_motions)[0]
        self.residual = 0.0
        """Largest relative residual of any solution so far."""
        self._factor: Factor | None = None

    @property
    def n_unknowns(self) -> int:
        """How many unknowns the system has."""
        return self.n_coordinates + int(self._ties.compliance.size)

    def compliance(self) -> Array:
        """Return the compliance (6, 6) of the tool, SI, world axes, at the tool point."""
        k = np.column_stack([self._tool @ self.solve(load) for load in self._tool.toarray()])
        return np.asarray(0.5 * (k + k.T))

    def solve(self, load: Array, error: float = _EXACT) -> Array:
        """Return the coordinates (n,) under a load (n,), to a relative ``error`` or to rounding.

        Free motions stay where they are. Raises `CadError` if no solution is found.
        """
        if self._factor is None:
            self._factor = Factor(self._definite_lower())
        n = self.n_coordinates
        b = np.concatenate([load, np.zeros(self._ties.compliance.size)])
        x: Array = np.zeros_like(b)
        residual, last = b, 1.0
        for _ in range(_MOST_CORRECTIONS):
            step = self._factor.solve(residual)
            # Along what nothing holds, the weak springs answer to rounding alone.
            step[:n] -= self._free @ (self._free.T @ step[:n])
            x += step
            residual = b - self.apply(x)
            size = float(np.linalg.norm(x[:n]))
            share = float(np.linalg.norm(step[:n])) / size if size else 0.0
            # Each correction is smaller than the last by about the same factor.
            if share * min(1.0, share / last) < error or _GOOD > share > 0.3 * last:
                break
            last = share
        else:
            raise CadError(
                "the equations of the whole robot could not be solved: corrections of "
                f"{share:.1e} are left",
                mend="take another --size or --order, or a posture farther from singular ones",
            )
        self.residual = max(
            self.residual, float(np.linalg.norm(residual[:n]) / np.linalg.norm(load))
        )
        return x[:n]

    def apply(self, x: Array) -> Array:
        """Return the left-hand sides (n + m,) of the equations."""
        n = self.n_coordinates
        out = np.empty_like(x)
        for name, at in self._at.items():
            out[at] = self.bodies[name].stiffness @ x[at]
        out[:n] += self._ties.rows.T @ x[n:]
        out[n:] = self._ties.rows @ x[:n] - self._ties.compliance * x[n:]
        return out

    def apply_mass(self, x: Array) -> Array:
        """Return the mass (n, n) times coordinates (n,)."""
        out = np.empty_like(x)
        for name, at in self._at.items():
            out[at] = self.bodies[name].mass @ x[at]
        if self.robot.tool.mass:
            out += self.robot.tool.mass * (self._tool[:3].T @ (self._tool[:3] @ x))
        return out

    def _find_free_motions(self) -> Array:
        """Return the free motions: no part deforms in them, so rigid bodies' motions span them."""
        scale = np.tile(np.repeat([self._reach, 1.0], 3), len(self.bodies))
        rigid = self._all_rigid()
        rows = (self._ties.rows @ rigid) * scale
        rows[~self._ties.turns] /= self._reach
        return np.asarray(rigid @ (scale[:, None] * null_space(np.asarray(rows))))

    def _all_rigid(self) -> Array:
        """Return the coordinates (n, 6 bodies) of unit twists of each body at its origin."""
        out = np.zeros((self.n_coordinates, 6 * len(self.bodies)))
        for i, (name, at) in enumerate(self._at.items()):
            turn = np.kron(np.eye(2), self.frames[name].rotation.T)
            out[at, 6 * i : 6 * i + 6] = self.bodies[name].at_origin @ turn
        return out

    def _port_rows(self, body: str, port: str, point: Array) -> csr_array:
        """Return the rows (6, n) of the twist at a point (3,), world axes, that a port carries."""
        if body == BASE:
            return csr_array((6, self.n_coordinates))
        frame, reading = self.frames[body], self.bodies[body].readings[port]
        turn = np.kron(np.eye(2), frame.rotation)
        shift = twist_shift(point - frame.point(reading.point))
        own = coo_array(csr_array(shift @ turn) @ reading.rows)
        columns = own.col + self._at[body].start
        return csr_array((own.data, (own.row, columns)), shape=(6, self.n_coordinates))

    def _tie(self) -> _Ties:
        rows, compliance, turns = [csr_array((0, self.n_coordinates))], [], []
        for joint in self.robot.joints.values():
            point = self.places.joint_point[joint.name]
            relative = self._port_rows(joint.to_body, joint.to_port, point) - self._port_rows(
                joint.from_body, joint.from_port, point
            )
            # Directions of a universal joint are not perpendicular to each other.
            into = np.linalg.inv(self.places.joint_directions[joint.name])
            held = held_directions(joint)
            rows.append(csr_array(into[held]) @ relative)
            compliance += [_compliance(joint, i) for i in held]
            turns += [i >= 3 for i in held]
        stacked = csr_array(block_array([[one] for one in rows], format="csr"))
        return _Ties(stacked, np.array(compliance), np.array(turns, dtype=bool))

    def _definite_lower(self) -> coo_array:
        """Return the lower triangle of the matrix with weak springs that make it quasi-definite."""
        n, ties = self.n_coordinates, self._ties
        rigidity = max(body.rigidity for body in self.bodies.values())
        blocks = []
        for name, at in self._at.items():
            body = self.bodies[name]
            lower = _lower(body.stiffness, _WEAK * rigidity * body.weak)
            blocks.append((lower.row + at.start, lower.col + at.start, lower.data))
        own = coo_array(ties.rows)
        blocks.append((own.row + n, own.col, own.data))
        soft = _SOFT / rigidity / np.where(ties.turns, self._reach**2, 1.0)
        last = n + np.arange(ties.compliance.size)
        blocks.append((last, last, -(ties.compliance + soft)))
        rows, columns, values = (np.concatenate(parts) for parts in zip(*blocks, strict=True))
        shape = (self.n_unknowns, self.n_unknowns)
        return coo_array((values, (rows, columns)), shape=shape)


def held_directions(joint: Joint) -> list[int]:
    """Return which of its six directions a joint holds, stiffly or softly."""
    return [i for i, freedom in enumerate(joint.freedoms) if freedom is not Freedom.PASSIVE]


def _compliance(joint: Joint, direction: int) -> float:
    """Return the compliance of a direction that is held, 0 if it is blocked."""
    stiffness = joint.stiffness[direction]
    return 0.0 if joint.freedoms[direction] is Freedom.BLOCKED else float(1.0 / stiffness)


def _lower(K: csr_array, diagonal: Array) -> coo_array:
    """Return the lower triangle of K with a diagonal added; all of the diagonal is there."""
    own = coo_array(K)
    kept = own.row > own.col
    n = np.arange(K.shape[0], dtype=own.row.dtype)
    row = np.concatenate([own.row[kept], n])
    col = np.concatenate([own.col[kept], n])
    return coo_array(
        (np.concatenate([own.data[kept], K.diagonal() + diagonal]), (row, col)), K.shape
    )
