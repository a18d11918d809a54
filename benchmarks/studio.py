"""The studio: from a slider's value to the quantity over the whole workspace."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from benchmarks.machine import Machine as Processor
from benchmarks.table import show
from stiffkit.compiled import limited_threads
from stiffkit.robot import RobotFile
from stiffkit.studio.machine import Machine, Variant
from stiffkit.studio.sliders import in_si

MOVED = {
    "five-bar": "distal",
    "biglide": "L1",
    "delta": "rod",
    "orthoglide": "L",
    "hexapod-cubic": "edge",
}
"""Which parameter is drawn along, by robot."""
_POSTURES = 10_000
_EVENTS = 60
_STEPS = 200
"""Steps of a slider."""
_POSES = 20


@dataclass(frozen=True)
class Slide:
    """A slider drawn slowly around the file's own value; milliseconds of a processor."""

    robot: str
    parameter: str
    postures: int
    start: float
    """s, to read, assemble and compile."""
    reading: float
    """The robot file with another value."""
    closing: float
    """Loops, closed anew."""
    quantity: float
    """Deflections of the refined model from compliances at all postures."""
    event: float
    """All of it, the median."""
    slowest: float
    """All of it, the slowest of the events."""
    stiffness_only: float
    """All of it where no length changes."""
    pose: float
    """A tool pose that was not looked at before: posture, compliance and deflections."""


def measure(name: str) -> Slide:
    """Return what a slider of a robot takes from event to numbers."""
    with limited_threads(1):
        began = time.thread_time()
        machine = Machine(name, points=_POSTURES)
        return _drawn(machine, name, time.thread_time() - began)


def _drawn(machine: Machine, name: str, start: float) -> Slide:
    slider, file = machine.parameters[MOVED[name]], RobotFile(name)
    reading, variant, quantity = [], [], []
    for i in range(1, _EVENTS + 1):
        value = slider.value + (i - _EVENTS / 2 + 0.5) * (slider.high - slider.low) / _STEPS
        given = {slider.name: in_si(value, slider.unit)}
        reading.append(_milliseconds(partial(file.robot, given)))
        values = {slider.name: value}
        variant.append(_milliseconds(partial(machine.variant, values)))
        quantity.append(_milliseconds(partial(_look, machine, values)))
    events = [a + b for a, b in zip(variant, quantity, strict=True)]
    return Slide(
        robot=name,
        parameter=slider.name,
        postures=machine.variant().poses.shape[1],
        start=start,
        reading=statistics.median(reading),
        closing=statistics.median(variant) - statistics.median(reading),
        quantity=statistics.median(quantity),
        event=statistics.median(events),
        slowest=max(events),
        stiffness_only=_of_stiffness(machine),
        pose=_of_pose(machine),
    )


def _look(machine: Machine, values: dict[str, float]) -> object:
    return machine.variant(values).quantity("deflection_translation", "refined", machine.loads[0])


def _of_stiffness(machine: Machine) -> float:
    """Return what a drive's stiffness takes; nan if none is a parameter."""
    drives = [s for s in machine.parameters.values() if s.unit.startswith("N")]
    if not drives:
        return float("nan")
    own = drives[0]
    times = [
        _milliseconds(partial(_look, machine, {own.name: own.value * (1.0 + 0.005 * i)}))
        for i in range(1, 20)
    ]
    return statistics.median(times)


def _of_pose(machine: Machine) -> float:
    variant, rng = machine.variant(), np.random.default_rng(0)
    times = []
    for i in rng.choice(np.flatnonzero(variant.reached), _POSES):
        shift = 1e-3 * variant.size * rng.uniform(-1.0, 1.0, len(variant.swept))
        pose = {
            name: float(value)
            for name, value in zip(variant.swept, variant.poses[:, i] + shift, strict=True)
        }
        times.append(_milliseconds(partial(_look_at, variant, pose)))
    return statistics.median(times)


def _look_at(variant: Variant, pose: dict[str, float]) -> object:
    return variant.at(pose).result()


def _milliseconds(work: Callable[[], object]) -> float:
    """Return what some work takes of a processor: all of it is done by this thread."""
    began = time.thread_time()
    work()
    return 1e3 * (time.thread_time() - began)


def run_studio(_this: Processor) -> list[Any]:
    """Table of the studio's answers."""
    rows = [measure(name) for name in MOVED]
    show(
        f"Studio: a slider drawn over {_EVENTS} of its {_STEPS} steps, deflections of the refined"
        " model at all postures, loops closed anew; milliseconds of a processor",
        (
            *("robot", "parameter", "postures", "start, s", "reading", "closing", "quantity"),
            *("event", "slowest", "stiffness only", "pose"),
        ),
        [
            (
                *(r.robot, r.parameter, r.postures, r.start, r.reading, r.closing, r.quantity),
                *(r.event, r.slowest, r.stiffness_only, r.pose),
            )
            for r in rows
        ],
    )
    return rows
