"""What `stiffkit check` says of a robot: its structure, and what may be wrong with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stiffkit.kinematics.home import NEAR_HINTS
from stiffkit.robot import DIRECTIONS, Freedom, Robot
from stiffkit.study.analysis import Analysis
from stiffkit.study.grid import pose_grid
from stiffkit.study.map import postures_of

Array = NDArray[np.float64]

_PROBES = 27
"""About how many postures tell whether a workspace is within reach."""


@dataclass(frozen=True)
class Summary:
    """Facts about a robot, in reading order, and warnings."""

    facts: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]


def summarise(robot: Robot | Analysis) -> Summary:
    """Return the summary of a robot at its home posture.

    Raises AssemblyError if it cannot be put together.
    """
    analysis = robot if isinstance(robot, Analysis) else Analysis(robot)
    robot = analysis.robot
    kinematics, mobility = analysis.kinematics, analysis.kinematics.mobility
    exact = analysis.refined.at_home
    home = kinematics.home.tool[:, 0]
    elastic = sum(link.compliance is not None for link in robot.links.values())
    drives = _drives(robot)
    facts = [
        ("robot", robot.title),
        ("bodies", f"{mobility.n_bodies} moving, {elastic} of them elastic"),
        ("joints", _count_kinds(robot)),
        ("drives", ", ".join(drives) or "none"),
        ("independent loops", str(mobility.n_loops)),
        ("mobility, counted", f"{mobility.counted} (Kutzbach)"),
        ("mobility at home", _mobility_words(mobility.numeric, mobility.idle)),
        ("degree of over-constraint", str(mobility.over_constraint)),
        ("tool coordinates", ", ".join(kinematics.asked) or "none: the tool cannot move"),
        ("home", _pose_words(home)),
        ("stiffness, refined", _method_words(analysis.refined.method)),
        ("stiffness, simplified", _method_words(analysis.simplified.method)),
    ]
    free = [analysis.words(m, home) for m in exact.free_motions]
    idle = [analysis.words(m, home) for m in exact.idle_motions]
    facts.append(("free motions", "; ".join(free) or "none"))
    if idle:
        facts.append(("idle motions", "; ".join(idle)))
    return Summary(tuple(facts), tuple(_warnings(analysis, free, len(drives))))


def probe_workspace(analysis: Analysis) -> list[str]:
    """Return in words how much of a sparse grid over the workspace is out of reach, if any is.

    Ways around holes of the workspace are not looked for, unlike for maps.
    Raises PoseError if the workspace is over coordinates in which the tool cannot be moved.
    """
    workspace = analysis.robot.workspace
    if not workspace.ranges and workspace.polygon is None and workspace.points is None:
        return []
    grid = pose_grid(analysis.robot, _PROBES)
    postures = postures_of(analysis, grid, detours=False)
    missed = np.flatnonzero(~postures.reached & grid.inside)
    if not missed.size:
        return []
    first = {name: values[missed[0]] for name, values in grid.values().items()}
    place = ", ".join(f"{name} = {_in_engineers_unit(name, x)}" for name, x in first.items())
    tried = _count(int(grid.inside.sum()), "posture")
    return [f"workspace: of {tried} tried, {missed.size} not reached from home, such as {place}"]


def _in_engineers_unit(name: str, value: float) -> str:
    if name.startswith("r"):
        return f"{np.degrees(value):.4g} deg"
    return f"{1e3 * value:.6g} mm"


def _warnings(analysis: Analysis, free: list[str], n_drives: int) -> list[str]:
    mobility = analysis.kinematics.mobility
    needed = mobility.numeric - mobility.idle
    warnings = list(analysis.robot.notes)
    home = analysis.kinematics.home_found
    if home.off_by > NEAR_HINTS:
        actual = dict(
            zip(
                analysis.kinematics.joint_names,
                analysis.kinematics.home.joints[:, 0],
                strict=True,
            )
        )
        words = ", ".join(
            f"{name} = {np.degrees(q):.4g} deg" if name[-2] == "r" else f"{name} = {1e3 * q:.4g} mm"
            for name, q in actual.items()
            if name.rpartition(".")[0] == home.off_at
        )
        warnings.append(
            f"the nearest assembly at home is far from what the file gives for"
            f" '{home.off_at}': {words}"
        )
    if free and analysis.refined.uncontrolled:
        warnings.append(
            f"{_count(needed, 'degree')} of freedom and {_count(n_drives, 'drive')}:"
            " nothing holds the free motions, which 'stiffkit check' names"
        )
    elif free:
        warnings.append("the home posture is singular: choose another one")
    elif n_drives > needed:
        warnings.append(
            f"{_count(n_drives, 'drive')} for {_count(needed, 'degree')} of freedom: they can fight"
        )
    if not analysis.robot.loads:
        warnings.append("no load cases: maps show stiffness only, no deflections")
    return warnings


def _drives(robot: Robot) -> list[str]:
    return [
        f"{joint.name}.{motion}"
        for joint in robot.joints.values()
        for motion, freedom in zip(DIRECTIONS, joint.freedoms, strict=True)
        if freedom is Freedom.DRIVEN
    ]


def _count(number: int, word: str) -> str:
    return f"{number} {word}" if number == 1 else f"{number} {word}s"


def _count_kinds(robot: Robot) -> str:
    kinds = [joint.kind for joint in robot.joints.values()]
    counted = ", ".join(f"{kinds.count(kind)} {kind}" for kind in dict.fromkeys(kinds))
    return f"{len(kinds)}: {counted}"


def _mobility_words(numeric: int, idle: int) -> str:
    return f"{numeric}, of which {idle} idle" if idle else str(numeric)


def _pose_words(tool: Array) -> str:
    position = ", ".join(f"{x + 0.0:.6g}" for x in (1e3 * tool[:3]).round(6))
    rotation = ", ".join(f"{x + 0.0:.4g}" for x in np.degrees(tool[3:]).round(6))
    return f"({position}) mm, rotation vector ({rotation}) deg"


def _method_words(method: str) -> str:
    return {
        "composition": "series and parallel composition, compiled",
        "jacobian": "Jacobian and drives, compiled",
        "assembly": "general assembly, one posture at a time",
    }[method]
