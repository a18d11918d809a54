"""Section 5 of Pashkevich 2009: the Orthoglide's links (Table 7) and its stiffness (Table 8).

A. Pashkevich, A. Klimchik, D. Chablat, P. Wenger, "Accuracy improvement for stiffness modeling of
parallel manipulators", Proc. 42nd CIRP Conference on Manufacturing Systems, 2009. The header of
Table 8 is garbled: its columns are k_tran in 1e-4 mm/N and k_rot in 1e-7 rad/(N mm).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stiffkit.fea import is_installed
from stiffkit.progress import Progress
from stiffkit.reproduce.over_constraint import OverConstraint, study_over_constraint
from stiffkit.reproduce.rows import PrintedRow
from stiffkit.robot import Robot, load_robot
from stiffkit.spatial.rotation import Array
from stiffkit.study import analyse_pose

SI_PER_MM = np.array([1e-3] * 3 + [1e3] * 3)
"""mm/N to m/N, and rad/(N mm) to rad/(N m)."""

COLUMNS = ("k11", "k22", "k33", "k44", "k55", "k66")

SINGLE, FOUR, LINEAR, PARABOLIC = (
    "single beam",
    "four beams",
    "finite elements, linear mesh",
    "finite elements, parabolic mesh",
)

TABLE_7: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "foot": {
        SINGLE: ("3.45e-4", "3.45e-4", "18.1e-4", "2.10e-7", "2.10e-7", "0.91e-7"),
        FOUR: ("2.77e-4", "4.34e-4", "17.9e-4", "2.11e-7", "1.95e-7", "0.91e-7"),
        LINEAR: ("2.45e-4", "3.24e-4", "15.9e-4", "2.07e-7", "2.06e-7", "1.71e-7"),
        PARABOLIC: ("2.77e-4", "4.15e-4", "19.4e-4", "2.29e-7", "2.30e-7", "0.84e-7"),
    },
    "axle": {
        SINGLE: ("1.34e-6", "2.65e-5", "2.65e-5", "4.29e-8", "3.18e-8", "3.18e-8"),
        LINEAR: ("1.99e-6", "1.29e-5", "1.50e-5", "6.81e-6", "8.23e-6", "2.67e-6"),
        PARABOLIC: ("6.23e-6", "2.83e-5", "2.59e-5", "2.77e-7", "4.84e-7", "1.20e-7"),
    },
    "bar": {
        SINGLE: ("3.75e-5", "4.38e-2", "1.09e-1", "3.96e-6", "3.40e-6", "1.37e-6"),
        LINEAR: ("4.50e-5", "3.64e-2", "8.01e-2", "3.76e-6", "2.65e-6", "1.09e-6"),
        PARABOLIC: ("4.55e-5", "5.08e-2", "2.33e-1", "2.88e-5", "7.19e-6", "1.50e-6"),
    },
}
"""Compliances by part and method, mm/N and rad/(N mm); those of an axle are of its half."""

_ASSUMED = {
    "foot": "150 mm long, section 16 x 26 mm turned by 45 degrees, E = 70 GPa, nu = 0.346, the "
    "polar moment for torsion: inferred, from six numbers",
    "axle": "50 mm long, 26 mm thick, the same material: inferred; k11 is cut off, not rounded",
    "bar": "A = 118.1 mm2, Iy = 1302 mm4, Iz = 3236 mm4, J = 3011 mm4: fitted to this very row, "
    "so that it follows is no test; a box of 16.4 x 10 mm with walls of 2.85 mm has all four, J "
    "within 4 %",
}
_OTHER = (
    "the parts themselves are not printed, so the row cannot be reproduced; ours is the part of "
    "the robot orthoglide-cad, with the printed lengths and the sections of the single beams"
)
_PARTS = {"foot": "foot_1", "axle": "near_left_1", "bar": "bar_left_1"}
_PREFIXES = {"foot": ("foot_",), "axle": ("near_", "far_"), "bar": ("bar_",)}


PLACES = (-0.0735, 0.0, 0.1265)
"""m, on the diagonal of the cube: its two corners and the isotropic posture."""


@dataclass(frozen=True, eq=False)
class Orthoglide:
    """Section 5, computed again."""

    rows: tuple[PrintedRow, ...]
    """Tables 7 and 8."""
    over_constraint: OverConstraint
    """Of the links from finite elements."""

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "rows": [row.as_json() for row in self.rows],
            "over_constraint": self.over_constraint.as_json(),
        }


def study_orthoglide(progress: Progress | None = None) -> Orthoglide:
    """Compute Tables 7 and 8, and what the over-constraints do.

    Where the library for finite elements is missing, our own parts are left out.
    """
    rows = table_rows(progress, with_cad=is_installed())
    lean = study_over_constraint(load_robot("orthoglide-table-7"), PLACES)
    return Orthoglide(tuple(rows), lean)


def table_rows(progress: Progress | None = None, *, with_cad: bool = True) -> list[PrintedRow]:
    """Return the rows of Tables 7 and 8 beside ours.

    ``with_cad`` takes finite elements of our own parts for information, which are solved if they
    have not been before.
    """
    from_cad = load_robot("orthoglide-cad", progress=progress) if with_cad else None
    return [*_table_7(from_cad), *_table_8(from_cad)]


def in_table_axes(robot: Robot, part: str) -> Array:
    """Return the compliance (6, 6), SI, of a part of an Orthoglide in the axes of Table 7.

    The table's axes of a foot are those of its leg, turned so that z lies along the axles; a foot
    whose own x runs along it, with y along the axles, is turned into them.
    """
    link = robot.links[_PARTS[part]]
    if link.compliance is None:
        raise ValueError(f"{link.name} is rigid")
    tip = link.ports["tip"].position
    if part != "foot" or abs(tip[1]) > 1e-9:
        return link.compliance
    c = np.sqrt(0.5)
    turn = np.kron(np.eye(2), np.array([[c, 0, -c], [c, 0, c], [0, -1, 0]]))
    return np.asarray(turn @ link.compliance @ turn.T)


def with_table_links(method: str, *, rigid_axle: bool) -> Robot:
    """Return the Orthoglide with the diagonals of a method of Table 7.

    The table prints nothing else; the other elements are those that give each pair of directions
    the correlation that it has in a beam.
    """
    robot = load_robot("orthoglide-table-7")
    links = dict(robot.links)
    for part, prefixes in _PREFIXES.items():
        own = in_table_axes(robot, part)
        printed = np.array([float(text) for text in TABLE_7[part][method]]) * SI_PER_MM
        scale = np.sqrt(printed / np.diag(own))
        k = own * np.outer(scale, scale)
        rigid = part == "axle" and rigid_axle
        for name, link in links.items():
            if name.startswith(prefixes):
                links[name] = replace(link, compliance=None if rigid else k)
    return replace(robot, links=links)


def _table_7(from_cad: Robot | None) -> list[PrintedRow]:
    beams = load_robot("orthoglide")
    rows = []
    for part, methods in TABLE_7.items():
        for method, printed in methods.items():
            ours, known, assumed = None, "", "the segments are not printed"
            if method == SINGLE:
                ours = _diagonal(beams, part)
                known = {"bar": "L = 310 mm", "axle": "d = 100 mm"}.get(part, "")
                assumed = _ASSUMED[part]
            elif method == PARABOLIC and from_cad is not None:
                ours, assumed = _diagonal(from_cad, part), _OTHER
            elif method in (LINEAR, PARABOLIC):
                assumed = "neither the parts nor the meshes are printed"
            rows.append(
                PrintedRow(
                    table="Table 7",
                    row=f"{part}, {method}",
                    columns=COLUMNS,
                    printed=printed,
                    ours=ours,
                    unit="mm/N, rad/(N mm)",
                    known=known,
                    assumed=assumed,
                    is_other=method == PARABOLIC,
                )
            )
    return rows


def _diagonal(robot: Robot, part: str) -> tuple[float, ...]:
    return tuple((np.diag(in_table_axes(robot, part)) / SI_PER_MM).tolist())


_LINKS = "Table 7's diagonals"
_POSTURE = (
    "the isotropic posture, drives of 1e5 N/mm (what remains of 3.10 with Table 7's links), "
    "correlations of the other elements as in beams"
)
_MAJOU = "the links of Majou et al. are not printed"
_WHY_ROT = (
    "k_tran follows to all digits, k_rot is off by 4 %: it hangs on elements beside the diagonals, "
    "which are not printed"
)


def _table_8(from_cad: Robot | None) -> list[PrintedRow]:
    linear = {rigid: with_table_links(LINEAR, rigid_axle=rigid) for rigid in (True, False)}
    rigid_axle = with_table_links(PARABOLIC, rigid_axle=True)
    own = "ours is the robot orthoglide-cad, other parts than the authors'"
    return [
        _row_8("Majou et al. with additional passive joint", "3.68", "2.77", assumed=_MAJOU),
        _row_8("Majou et al. without it", "3.68", "1.26", assumed=_MAJOU),
        _row_8("over-constrained lump model [6]", "2.78", "1.94", linear[True], why=_WHY_ROT),
        _row_8("the same with elastic axles [6]", "2.93", "2.02", linear[False], why=_WHY_ROT),
        _row_8(
            "whole manipulator, linear mesh", "3.05", "2.05", assumed="the parts are not printed"
        ),
        _row_8("lump model with rigid axis, parabolic mesh", "3.10", "2.31", rigid_axle),
        _row_8(
            "whole manipulator, parabolic mesh",
            "3.02",
            "2.46",
            from_cad,
            assumed=own if from_cad is not None else "the parts are not printed",
            is_other=True,
        ),
    ]


def _row_8(
    row: str,
    k_tran: str,
    k_rot: str,
    robot: Robot | None = None,
    *,
    assumed: str = _POSTURE,
    is_other: bool = False,
    why: str = "",
) -> PrintedRow:
    ours = None if robot is None else _isotropic(robot)
    return PrintedRow(
        table="Table 8",
        row=row,
        columns=("k_tran", "k_rot"),
        printed=(k_tran, k_rot),
        ours=ours,
        unit="1e-4 mm/N, 1e-7 rad/(N mm)",
        known=_LINKS if ours is not None and not is_other else "",
        assumed=assumed,
        is_other=is_other,
        why=why,
    )


def _isotropic(robot: Robot) -> tuple[float, float]:
    """Return k_tran and k_rot at home in the units of Table 8."""
    k = analyse_pose(robot).compliance
    if k is None:
        raise ValueError(f"{robot.name} has no compliance at home")
    return float(k[0, 0] / 1e-3 / 1e-4), float(k[3, 3] / 1e3 / 1e-7)
