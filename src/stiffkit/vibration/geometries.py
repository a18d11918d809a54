"""The fast model for many geometries of one robot, all with one basis.

Seen in links' and joints' own axes and measured by the root of their energy, the modes of one
geometry look like those of another, as those of one posture look like another's: modes of a few
postures of a few geometries span a basis for all. Only the numbers in it differ, so one compiled
function serves them all. How far a frequency can be trusted is told by how much it changes when the
last vectors of the basis are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from stiffkit.compiled import Backend, Constants, GeometriesFunction
from stiffkit.errors import LinkError
from stiffkit.kinematics import SpanningTree
from stiffkit.network import build_network, elements_of
from stiffkit.robot import Robot
from stiffkit.vibration.bodies import Bodies, Discretisation, make_bodies
from stiffkit.vibration.fast import frequencies_of, lower_triangular
from stiffkit.vibration.own_axes import basis_of
from stiffkit.vibration.reduced import Basis, ReducedKernel, add_basis_and_masses

Array = NDArray[np.float64]

LEFT_OUT = 4
"""Vectors of the basis whose absence tells the error."""
_NOTHING = 1e-13
"""Entries of masses below this share of their row and column are rounding."""
_TOGETHER = 2048
"""Postures at a time: each has constants of its own, some thousand of them."""


class FastGeometries:
    """The fast model of geometries that share a topology."""

    def __init__(self, tree: SpanningTree, length: float, U: Array, backend: Backend) -> None:
        """Take one of the geometries, its typical length (m) and the basis U (n_energy, r).

        U holds orthonormal elastic coordinates in their own axes, most important ones first, as
        `stiffkit.vibration.modes_in_own_axes` gives them.
        """
        self.U = U
        self._backend = backend
        self._network = build_network(tree.robot)
        masses = self._masses(tree.robot)
        self._kinds = _kinds(masses)
        self._kernel = ReducedKernel(tree, length, masses, self._basis(tree.robot, masses)).kernel()
        self._functions: dict[bytes, GeometriesFunction] = {}

    def _masses(self, robot: Robot) -> Bodies:
        masses = make_bodies(robot, Discretisation())
        return Bodies(
            {name: _settled(mass) for name, mass in masses.rigid.items()},
            {name: replace(e, mass=_settled(e.mass)) for name, e in masses.elastic.items()},
            masses.tool_mass,
        )

    def _basis(self, robot: Robot, masses: Bodies) -> Basis:
        return basis_of(elements_of(self._network, robot), masses.mode_stiffness, self.U)

    def constants(self, robot: Robot, length: float, elasticity: Constants) -> Constants:
        """Return what the kernel reads of a geometry, whose `add_elasticity` is known.

        Raises LinkError where a link's mass cannot be distributed, or is in another way than in
        the geometry that the kernel was made of.
        """
        constants = elasticity.copy()
        masses = self._masses(robot)
        if _kinds(masses) != self._kinds:
            raise LinkError(
                f"in {robot.name} with these values masses lie in another way: a link whose mass"
                " was spread along it moves as a rigid body, or the other way round",
                mend="let the masses and centres of mass of links follow the parameters",
            )
        add_basis_and_masses(constants, robot, masses, self._basis(robot, masses), length)
        return constants

    def lowest(self, constants: Sequence[Constants], q: Array) -> tuple[Array, Array]:
        """Return the lowest frequency (G, F), Hz, of F postures q (n_coordinates, G, F) of each.

        The second array (G, F) is its relative change where the last `LEFT_OUT` vectors of the
        basis are left out. NaN where a posture is not defined.
        """
        found, change = np.full((2, *q.shape[1:]), np.nan)
        patterns = [c.compiled_in for c in constants]
        grouped: dict[bytes, list[int]] = {}
        for i, (c, compiled_in) in enumerate(zip(constants, patterns, strict=True)):
            key = compiled_in.tobytes() + c.values[compiled_in].tobytes()
            grouped.setdefault(key, []).append(i)
        for key, numbers in grouped.items():
            if key not in self._functions:
                kernel = replace(self._kernel, constants=constants[numbers[0]])
                self._functions[key] = GeometriesFunction(kernel, self._backend)
            size = max(1, _TOGETHER // q.shape[2])
            for start in range(0, len(numbers), size):
                own = numbers[start : start + size]
                values = np.stack([constants[i].values for i in own], axis=1)
                found[own], change[own] = self._at(self._functions[key], values, q[:, own])
        return found, change

    def _at(self, function: GeometriesFunction, constants: Array, q: Array) -> tuple[Array, Array]:
        number = np.repeat(np.arange(q.shape[1]), q.shape[2])
        lower = function.at(constants, number)(q.reshape(q.shape[0], -1))
        known = np.flatnonzero(np.isfinite(lower).all(axis=0))
        r = self.U.shape[1]
        matrices = lower_triangular(lower[:, known], r)
        fewer = max(1, r - LEFT_OUT)
        found, change = np.full((2, lower.shape[1]), np.nan)
        found[known] = _lowest(matrices)
        change[known] = _lowest(matrices[:, :fewer, :fewer]) / found[known] - 1.0
        return found.reshape(q.shape[1:]), change.reshape(q.shape[1:])


def _kinds(masses: Bodies) -> tuple[tuple[str, ...], tuple[tuple[str, int], ...]]:
    """Return which links are rigid, and which are elastic, with the size of their masses."""
    elastic = tuple((name, element.mass.shape[0]) for name, element in masses.elastic.items())
    return tuple(masses.rigid), elastic


def _lowest(matrices: Array) -> Array:
    """Return the lowest frequency (N,), Hz, of matrices (N, r, r) with eigenvalues 1/omega^2."""
    values = np.asarray(np.linalg.eigvalsh(matrices, UPLO="L")[:, ::-1], dtype=float)
    return np.asarray(frequencies_of(values, 1)[0])


def _settled(mass: Array) -> Array:
    """Return a mass matrix with zeros in place of rounding.

    What is zero, and so what shows of the topology, is then the same for all geometries.
    """
    root = np.sqrt(np.abs(np.diag(mass)))
    return np.where(np.abs(mass) > _NOTHING * np.outer(root, root), mass, 0.0)
