"""What Briot 2009 says of the machine as it is, beside what comes out here."""

from __future__ import annotations

import numpy as np

from stiffkit.reproduce.briot_2009_family import MACHINE
from stiffkit.reproduce.briot_2009_machine import MODES, Machine
from stiffkit.reproduce.statements import Outcome, Statement
from stiffkit.robot import load_robot

WITH_TOOL = "biglide-elastic-tool"
"""The machine with the link that the paper prints and leaves out of its figures."""
PLANAR = ("f_x", "f_y")
UM = 1e6
ABOUT = 0.1
"""Relative, what "about" allows."""

_NO_VALUES = "the figure is a picture, and the text has no values of its curves"


def is_about(ours: float, printed: float) -> bool:
    """Tell whether a number is "about" the printed one."""
    return abs(ours / printed - 1.0) <= ABOUT


def machine_statements(machine: Machine) -> list[Statement]:
    """Return sections 2.1, 2.2, 3.1 and 3.2, the introduction and the appendix."""
    return [
        _workspace(machine),
        *_deflections(machine),
        _simplified(machine),
        *_modes(machine),
        *_beam(machine),
        *_appendix(machine),
    ]


def unknown(figure: str, printed: str, ours: str, why: str = _NO_VALUES) -> Statement:
    """Return a figure whose values are not in the text."""
    return Statement(figure, printed, ours, Outcome.UNKNOWN, why)


def _range(values: object, factor: float = 1.0) -> str:
    """Return the least and the largest; what is far below a thousandth of it is zero."""
    data = factor * np.asarray(values, dtype=float)
    low, high = data.min(), data.max()
    return f"{low if low > 1e-6 * high else 0.0:.3g} to {high:.3g}"


def _workspace(machine: Machine) -> Statement:
    left, right = machine.x[0], machine.x[-1]
    parameters = load_robot(MACHINE).parameters
    printed = parameters["L1"].value - parameters["a"].value
    return Statement(
        "Figs 6, 12, 13 (c)",
        "the right end of the workspace is x = L1 - a",
        f"it is x = L1 = {right:.3g} m",
        Outcome.DIFFERS,
        f"x = L1 - a = {printed:.2g} m is left of the left end, x = a - L2 = {left:.3g} m; from"
        " there to L1 it is d, as eq. 11 has it",
    )


def _deflections(machine: Machine) -> list[Statement]:
    simplified, refined = machine.deflections["simplified"], machine.deflections["refined"]
    inner = machine.inner(0.9)
    ratios = {load: refined[load][inner] / simplified[load][inner] for load in PLANAR}
    middle = {load: float(np.median(ratio)) for load, ratio in ratios.items()}
    profile = {load: float(np.corrcoef(refined[load], simplified[load])[0, 1]) for load in PLANAR}
    over = float(refined["f_z"].max() / max(refined[load].max() for load in PLANAR))
    return [
        unknown(
            "Fig. 3",
            "deflections by the simplified model",
            f"{_range(simplified['f_x'], UM)} um under f_x, {_range(simplified['f_y'], UM)} um"
            " under f_y",
        ),
        unknown(
            "Fig. 5",
            "deflections by the refined model",
            f"{_range(refined['f_x'], UM)} um under f_x, {_range(refined['f_y'], UM)} um under f_y,"
            f" {_range(refined['f_z'], UM)} um under f_z",
        ),
        Statement(
            "2.2, Fig. 5",
            "the deformations along z are 3 times larger than those along x and y",
            f"the largest along z is {over:.2f} times the largest in the plane",
            Outcome.of(is_about(over, 3.0)),
        ),
        Statement(
            "2.2, Figs 3 and 5",
            "the planar deformations are about 10 times larger than with the simplified model",
            "in the middle nine tenths of the workspace "
            + " and ".join(
                f"{middle[load]:.1f} times under {load} ({_range(ratios[load])})" for load in PLANAR
            ),
            Outcome.of(*(is_about(middle[load], 10.0) for load in PLANAR)),
        ),
        Statement(
            "2.2, Figs 3 and 5",
            "the curves keep the same profile",
            "correlation of the two models' curves: "
            + ", ".join(f"{profile[load]:.2f} under {load}" for load in PLANAR),
            Outcome.of(*(profile[load] > 1.0 - ABOUT for load in PLANAR)),
            "under f_y both have a valley, but the refined one is steeper on the left, where leg 2"
            " lies across",
        ),
    ]


def _simplified(machine: Machine) -> Statement:
    lowest = int(np.argmin(machine.simplified))
    return Statement(
        "3.1, Fig. 7",
        "the first natural frequency (simplified) is superior to 710 Hz",
        f"it is at least {machine.simplified[lowest]:.1f} Hz, at x = {machine.x[lowest]:.2f} m, and"
        f" at most {machine.simplified.max():.1f} Hz",
        Outcome.of(bool(machine.simplified[lowest] > 710.0)),
    )


def _modes(machine: Machine) -> list[Statement]:
    first, second = machine.refined
    leads = np.array([next(iter(shares)) == "leg_1" for shares in machine.shares])
    share = np.array([shares["leg_1"] for shares in machine.shares])
    where = machine.places[leads]
    led = f", from x = {where.min():.2f} to {where.max():.2f} m" if leads.any() else ""
    return [
        unknown(
            "Fig. 10",
            "the first two natural frequencies, refined model",
            f"{_range(first)} Hz and {_range(second)} Hz",
        ),
        Statement(
            "3.2, Fig. 11a",
            "the first mode is the bending of the robot along z",
            f"it is at {np.count_nonzero(machine.along_z[0])} of {machine.places.size} places",
            Outcome.of(bool(machine.along_z[0].all())),
        ),
        Statement(
            "3.2, Fig. 11b",
            "the second mode is planar, due to the bending of leg 1",
            f"it is planar at {np.count_nonzero(~machine.along_z[1])} of {machine.places.size}"
            f" places; leg 1 has {_range(share)} of the strain energy, more than any other part at"
            f" {np.count_nonzero(leads)} of them{led}",
            Outcome.of(not machine.along_z[1].any(), bool(leads.all())),
            "towards the ends a foot has more of it",
        ),
        Statement(
            "3.2",
            f"none of the {MODES} first modes is only due to the actuators",
            f"the drives have at most {machine.drive_share:.2f} of the strain energy of one of the"
            " first 60 at the centre",
            Outcome.of(machine.drive_share < 0.5),
        ),
    ]


def _beam(machine: Machine) -> list[Statement]:
    leg = machine.leg_1
    return [
        Statement(
            "3.2",
            "the first natural frequency of the equivalent beam of leg 1 is about 180 Hz",
            f"{leg['z']:.1f} Hz along z; in the plane, where the leg is slacker, {leg['y']:.1f} Hz",
            Outcome.of(is_about(leg["z"], 180.0)),
        ),
        Statement(
            "3.2",
            "20 rigid elements are within 1 % of theory",
            f"they are within {100.0 * machine.lumped_error:.2g} %",
            Outcome.of(machine.lumped_error < 0.01),
        ),
        Statement(
            "1",
            "longitudinal natural frequencies of a beam are many times smaller than those of"
            " bending",
            f"leg 1 as a beam: {leg['x']:.0f} Hz along itself, {leg['y']:.0f} and"
            f" {leg['z']:.0f} Hz in bending",
            Outcome.of(leg["x"] < min(leg["y"], leg["z"])),
            "a slip: they are many times larger, which is what the argument needs",
        ),
    ]


def _appendix(machine: Machine) -> list[Statement]:
    notes = load_robot(WITH_TOOL).notes
    repairs = [
        Statement(
            f"Appendix, {note.split(':')[0].removeprefix('links.')}",
            "the matrix of a link",
            note.split(": ", 1)[1],
            Outcome.DIFFERS,
            "no link can have the printed matrix; the robot file says how it is repaired",
        )
        for note in notes
        if "replaced" in note and not note.startswith("links.foot_2")
    ]
    return [*repairs, *_leg_2(machine)]


def _leg_2(machine: Machine) -> list[Statement]:
    inertia = load_robot(MACHINE).links["leg_2"].inertia
    if inertia is None:
        return []
    second = np.trace(inertia) / 2.0 - np.diag(inertia)
    longest = "xyz"[int(np.argmax(second))]
    return [
        Statement(
            "Appendix, leg_2",
            "the local x axis of J_Leg2 is along the leg",
            f"its mass extends along {longest}: the integrals of x^2, y^2 and z^2 over the mass are"
            f" {', '.join(f'{value:.2f}' for value in second)} kg m^2",
            Outcome.of(longest == "x"),
            "taken as printed; with the axes exchanged the first two frequencies at the centre"
            f" change by at most {100.0 * machine.turned_leg_2:.2g} %",
        )
    ]
