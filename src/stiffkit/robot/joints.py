"""The joints of a robot file."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from stiffkit.files.entry import Entry
from stiffkit.files.frames import read_frame
from stiffkit.files.problems import Problems
from stiffkit.robot.memo import PartMemo
from stiffkit.robot.model import BASE, DIRECTIONS, Freedom, Joint, Link
from stiffkit.robot.ports import read_port
from stiffkit.units import STIFFNESS_ROTATION, STIFFNESS_TRANSLATION

KINDS = ("fixed", "revolute", "prismatic", "cylindrical", "universal", "spherical", "planar")
RIGID = "rigid"


def read_joints(
    entries: Mapping[str, Entry], links: Mapping[str, Link], memo: PartMemo | None = None
) -> dict[str, Joint]:
    """Return the joints by name; ``memo`` knows joints read before.

    Raises FileError where one of them cannot exist.
    """
    memo = memo or PartMemo()
    joints: dict[str, Joint] = {}
    problems = Problems()
    for name, entry in entries.items():
        with problems.collect():
            if name in DIRECTIONS:
                raise entry.error(
                    f"'{name}' is the name of a tool coordinate", "choose another name"
                )
            bodies = (entry[end].text().partition(".")[0] for end in ("from", "to"))
            joints[name] = memo.get(
                f"joints.{name}",
                [entry],
                partial(_read_joint, name, entry, links),
                *(links.get(body) for body in bodies),
            )
    problems.check()
    return joints


def _read_joint(name: str, entry: Entry, links: Mapping[str, Link]) -> Joint:
    kind = _kind(entry)
    from_port, to_port = read_port(entry["from"], links), read_port(entry["to"], links)
    if from_port.body == to_port.body:
        raise entry["to"].error(
            f"the joint connects '{to_port.body}' with itself", "name two different bodies"
        )
    joint = Joint(
        name=name,
        kind=kind,
        axes=_axes(entry[kind]),
        from_body=from_port.body,
        T_from_joint=from_port.T_body_port @ read_frame(entry, towards="towards"),
        to_body=to_port.body,
        T_to_joint=to_port.T_body_port @ read_frame(entry, at="to_at", rotate="to_rotate"),
        from_port=from_port.name,
        to_port=to_port.name,
        freedoms=(),
        stiffness=np.zeros(6),
    )
    drives, springs = _drives(entry, joint), _springs(entry)
    for direction in sorted(drives.keys() & springs.keys()):
        raise entry["elastic"][direction].error(
            f"direction {direction} has a drive already",
            "give the drive's stiffness by 'drive' alone",
        )
    return with_freedoms(joint, drives, springs)


def _kind(entry: Entry) -> str:
    kinds = [kind for kind in KINDS if kind in entry]
    if not kinds:
        raise entry.error("the joint has no kind", f"add one of {', '.join(KINDS)}")
    if len(kinds) > 1:
        raise entry.error(f"the joint has two kinds, {' and '.join(kinds)}", "keep one of them")
    return kinds[0]


def _axes(entry: Entry) -> tuple[str, ...]:
    """Return the axes that a kind is given with: none, one or two."""
    if isinstance(entry.node.value, list):
        return tuple(axis.text() for axis in entry.elements())
    return (entry.text(),) if isinstance(entry.node.value, str) else ()


def _drives(entry: Entry, joint: Joint) -> dict[str, float]:
    """Return the stiffness of the driven directions; inf where the drive is rigid."""
    given = entry.get("drive")
    if given is None:
        return {}
    motions = joint.motions
    listed = ", ".join(motions)
    if not motions:
        raise given.error("a fixed joint has no motion to drive", "remove the drive")
    if not isinstance(given.node.value, dict):
        if len(motions) > 1:
            raise given.error(
                f"a {joint.kind} joint has several motions ({listed})",
                f"say which one is driven, for example 'drive: {{{motions[0]}: ...}}'",
            )
        return {motions[0]: _drive_stiffness(given, motions[0])}
    drives = {}
    for direction, stiffness in given.items():
        if direction not in motions:
            raise stiffness.error(
                f"the joint is not free in direction {direction}, so no drive can move it",
                f"the motions of this {joint.kind} joint are {listed}",
            )
        drives[direction] = _drive_stiffness(stiffness, direction)
    return drives


def _drive_stiffness(entry: Entry, direction: str) -> float:
    return math.inf if entry.is_text(RIGID) else _stiffness(entry, direction)


def _springs(entry: Entry) -> dict[str, float]:
    """Return the stiffness of the elastic directions."""
    given = entry.get("elastic")
    return {} if given is None else {key: _stiffness(one, key) for key, one in given.items()}


def _stiffness(entry: Entry, direction: str) -> float:
    is_rotation = direction.startswith("r")
    return entry.positive(STIFFNESS_ROTATION if is_rotation else STIFFNESS_TRANSLATION)


def with_freedoms(joint: Joint, drives: Mapping[str, float], springs: Mapping[str, float]) -> Joint:
    """Return the joint with what each of its six directions does, by its kind and axes.

    ``drives`` and ``springs`` give stiffnesses (N/m, N m/rad; inf if rigid) by direction; a motion
    of the joint that has neither is passive, any other direction is blocked.
    """
    states = dict.fromkeys(DIRECTIONS, (Freedom.BLOCKED, math.inf))
    states |= dict.fromkeys(joint.motions, (Freedom.PASSIVE, 0.0))
    states |= {direction: (Freedom.ELASTIC, value) for direction, value in springs.items()}
    states |= {direction: (Freedom.DRIVEN, value) for direction, value in drives.items()}
    return replace(
        joint,
        freedoms=tuple(states[direction][0] for direction in DIRECTIONS),
        stiffness=np.array([states[direction][1] for direction in DIRECTIONS]),
    )


def check_connected(
    joints: Mapping[str, Joint], links: Mapping[str, Link], entries: Mapping[str, Entry]
) -> None:
    """Raise FileError at links from which no chain of joints leads to the base."""
    neighbours: dict[str, set[str]] = {body: set() for body in (BASE, *links)}
    for joint in joints.values():
        neighbours[joint.from_body].add(joint.to_body)
        neighbours[joint.to_body].add(joint.from_body)
    reached, front = {BASE}, [BASE]
    while front:
        new = neighbours[front.pop()] - reached
        reached |= new
        front.extend(new)
    problems = Problems()
    for name in links:
        with problems.collect():
            if not neighbours[name]:
                raise entries[name].error(
                    "no joint connects this link", f"add a joint with 'to: {name}', or remove it"
                )
            if name not in reached:
                raise entries[name].error(
                    "no chain of joints leads from this link to the base",
                    "connect it, or what it hangs on, with the base",
                )
    problems.check()
