"""The verification of postures: the room's main door."""

from __future__ import annotations

import resource
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from stiffkit.errors import CadError, PoseError
from stiffkit.kinematics import Status
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import Robot
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.study import Analysis, PoseResult, analyse_modes, analyse_pose
from stiffkit.verify.body import Body, meshed_body, rigid_body
from stiffkit.verify.fit import Placed, find_gaps, find_overlaps
from stiffkit.verify.frequencies import lowest_frequencies
from stiffkit.verify.meshes import Meshed, Resolution, check_links, mesh_parts
from stiffkit.verify.places import Places
from stiffkit.verify.result import Compared, Verification, VerifiedPart, VerifiedPosture
from stiffkit.verify.whole import Whole


@dataclass(frozen=True, eq=False)
class _Asked:
    """A posture to be verified, by the reduced model."""

    at: Mapping[str, float]
    where: str
    """The posture in messages, "" where it is the only one."""
    pose: PoseResult
    compliance: Array
    """(6, 6)."""
    places: Places
    frames: Mapping[str, Frame]
    """T_world_body of the axes that each body is described in."""


def verify_postures(
    robot: Robot,
    postures: Sequence[Mapping[str, float]] = ({},),
    *,
    n_modes: int = 4,
    resolution: Resolution | None = None,
    allow_overlap: bool = False,
    allow_gaps: bool = False,
    progress: Progress | None = None,
) -> Verification:
    """Return the reduced model beside finite elements of the whole robot, at each posture.

    A posture, of which there is at least one, names tool coordinates (m, rad); independent ones
    that are missing are the home posture's. Of the ``n_modes`` lowest natural frequencies there may
    be none. Raises PoseError where a posture is out of reach, singular, or not held; CadError where
    an elastic link is not given by CAD, and, unless allowed, where parts overlap or interfaces of a
    joint do not meet.
    """
    start = time.perf_counter()
    report = progress or no_progress
    check_links(robot)
    analysis = Analysis(robot, prefer=[name for at in postures for name in at])
    asked = [_asked(analysis, at, only=len(postures) == 1) for at in postures]
    parts = mesh_parts(robot, resolution or Resolution(), report)
    report("looking how parts fit", 0.2)
    notes = [_misfits(robot, parts, one, allow_overlap, allow_gaps) for one in asked]
    same = _on_same_meshes(analysis, parts, report)
    bodies = bodies_of(robot, parts, report)
    verified = []
    for i, one in enumerate(asked):
        done = time.perf_counter()
        whole = Whole(robot, bodies, one.frames, one.places)
        report(f"solving {whole.n_unknowns} unknowns{one.where}", 0.4 + 0.6 * i / len(asked))
        compliance = whole.compliance()
        frequencies = lowest_frequencies(whole, n_modes) if n_modes else np.zeros(0)
        verified.append(
            VerifiedPosture(
                tool=one.pose.tool,
                reduced=one.compliance,
                same_meshes=_same_compliance(analysis, same, one),
                whole=compliance,
                frequencies=_frequencies(analysis, same, one.at, frequencies),
                residual=whole.residual,
                seconds=time.perf_counter() - done,
                notes=notes[i],
            )
        )
    return Verification(
        robot=robot.name,
        title=robot.title,
        postures=tuple(verified),
        parts=tuple(_described(part) for part in parts),
        rigid=tuple(name for name, link in robot.links.items() if link.cad is None),
        n_unknowns=whole.n_unknowns,
        seconds=time.perf_counter() - start,
        peak_memory=1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
    )


def _asked(analysis: Analysis, at: Mapping[str, float], *, only: bool) -> _Asked:
    """Return a posture by the reduced model. Raises PoseError where it has no compliance."""
    where = "" if only else f" at {','.join(f'{k}={v:.6g}' for k, v in at.items()) or 'home'}"
    pose = analyse_pose(analysis, at)
    compliance = _compliance(pose, where)
    q = analysis.kinematics.solve_at(at).coordinates[:, 0]
    places = Places(analysis.kinematics.tree, q)
    return _Asked(at, where, pose, compliance, places, frames_of(analysis.robot, places))


def _compliance(pose: PoseResult, where: str) -> Array:
    if pose.status is not Status.OK or pose.compliance is None:
        raise PoseError(
            f"{pose.status.word}{where}: {pose.reason}", mend="choose another posture by --at"
        )
    return pose.compliance


def frames_of(robot: Robot, places: Places) -> dict[str, Frame]:
    """Return T_world_body of the axes that each body is described in."""
    return {
        name: places.body[name]
        if link.cad is None
        else places.body[name] @ link.cad.solved.T_part_link.inverse
        for name, link in robot.links.items()
    }


def _misfits(
    robot: Robot, parts: list[Meshed], asked: _Asked, allow_overlap: bool, allow_gaps: bool
) -> tuple[str, ...]:
    """Return what is allowed of overlaps and gaps, in words; raise CadError for what is not."""
    placed = {
        name: Placed(
            meshed.part.part,
            {port.name: port for port in meshed.part.ports},
            asked.frames[name],
            meshed.part.mesh,
        )
        for meshed in parts
        for name in meshed.links
    }
    joints = list(robot.joints.values())
    gaps = [f"{gap.describe()}{asked.where}" for gap in find_gaps(joints, placed)]
    if gaps and not allow_gaps:
        raise CadError(
            "\n".join(gaps),
            mend="move or resize the parts, or choose other faces; --allow-gaps takes joints to "
            "bridge them rigidly, as the reduced model does",
        )
    overlaps = [f"{one.describe()}{asked.where}" for one in find_overlaps(joints, placed)]
    if overlaps and not allow_overlap:
        raise CadError(
            "\n".join(overlaps),
            mend="move the parts or choose another posture; --allow-overlap goes on, with both "
            "parts whole, as the reduced model does",
        )
    return (*gaps, *overlaps)


def _on_same_meshes(analysis: Analysis, parts: list[Meshed], report: Progress) -> Analysis:
    """Return the robot with links reduced on the meshes of the whole."""
    if all(part.is_own for part in parts):
        return analysis
    links = dict(analysis.robot.links)
    for i, part in enumerate(parts):
        report(f"reducing {part.links[0]}", 0.2 + 0.1 * i / len(parts))
        element = part.reduced()
        for name in part.links:
            links[name] = replace(links[name], compliance=element.compliance, superelement=element)
    return Analysis(replace(analysis.robot, links=links))


def bodies_of(robot: Robot, parts: list[Meshed], report: Progress) -> dict[str, Body]:
    """Return the bodies in the order of the robot's links; equal parts are one and the same."""
    meshed: dict[str, Body] = {}
    for i, part in enumerate(parts):
        report(f"assembling {part.links[0]}", 0.3 + 0.1 * i / len(parts))
        body = meshed_body(part.part.discretised(part.settings), part.part.ports)
        meshed |= dict.fromkeys(part.links, body)
    return {
        name: rigid_body(link) if link.cad is None else meshed[name]
        for name, link in robot.links.items()
    }


def _same_compliance(analysis: Analysis, same: Analysis, asked: _Asked) -> Array:
    """Return the compliance (6, 6) by links reduced on the meshes of the whole."""
    if same is analysis:
        return asked.compliance
    return _compliance(analyse_pose(same, asked.at), asked.where)


def _frequencies(
    analysis: Analysis, same: Analysis, at: Mapping[str, float], whole: Array
) -> tuple[Compared, ...]:
    if not whole.size:
        return ()
    reduced = analyse_modes(analysis, at, whole.size).frequencies_hz
    same_meshes = (
        reduced if same is analysis else analyse_modes(same, at, whole.size).frequencies_hz
    )
    return tuple(
        Compared(f"mode {i + 1}", *map(float, values))
        for i, values in enumerate(zip(reduced, same_meshes, whole, strict=False))
    )


def _described(meshed: Meshed) -> VerifiedPart:
    solved = meshed.link.solved
    return VerifiedPart(
        links=meshed.links,
        part=meshed.link.spec.cad.name,
        elements=meshed.part.mesh.check.n_tets,
        order=meshed.settings.order,
        unknowns=meshed.n_unknowns,
        estimate=solved.estimate,
        own_mesh=meshed.is_own,
    )
