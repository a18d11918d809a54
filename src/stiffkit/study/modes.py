"""The natural frequencies and mode shapes of one posture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from stiffkit.errors import LinkError, PoseError
from stiffkit.kinematics import Postures, Status
from stiffkit.robot import DIRECTIONS, Robot
from stiffkit.study.analysis import Analysis
from stiffkit.study.pose import out_of_reach, plain
from stiffkit.vibration import (
    Discretisation,
    ModalModel,
    Modes,
    ModesDrawing,
    describe_mode,
    draw_modes,
    simplified_modes,
    struck_robot,
)

Array = NDArray[np.float64]

VibrationModel = Literal["refined", "lumped", "lumped-eq25", "simplified"]
"""refined: links as consistent beam elements; lumped: links as rigid elements joined by springs
(Briot et al. 2009, section 3.2), passive joints condensed; lumped-eq25: the same with passive
joints as the paper prints them, for comparison; simplified: drives and platform mass only
(section 3.1)."""

MODELS_OF_VIBRATION: tuple[VibrationModel, ...] = ("refined", "lumped", "lumped-eq25", "simplified")

LUMPED_ELEMENTS = 20
"""Rigid elements of each link, as in Briot et al. 2009, section 3.2."""


@dataclass(frozen=True, eq=False)
class Mode:
    """One elastic mode of a posture."""

    frequency_hz: float
    description: str
    """What the tool does, and where the strain energy is."""
    tool: Array
    """(6,), the tool's twist, SI, world axes, at the tool point, for unit modal mass."""
    energy_shares: Mapping[str, float]
    """Share of the strain energy in each link and joint, largest first."""

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "frequency_hz": self.frequency_hz,
            "description": self.description,
            "tool": dict(zip(DIRECTIONS, plain(self.tool), strict=True)),
            "energy_shares": dict(self.energy_shares),
        }


@dataclass(frozen=True, eq=False)
class ModesResult:
    """The lowest elastic modes of one posture."""

    robot: str
    title: str
    model: VibrationModel
    status: Status
    """UNCONTROLLED or SINGULAR where the tool has motions that nothing holds; the elastic modes
    are given all the same."""
    reason: str
    """Why the status is not OK, "" if it is."""
    tool: Array
    """(6,), tool pose, m and rad; NaN where unreachable."""
    modes: tuple[Mode, ...] = ()
    """By ascending frequency."""
    n_existing: int = 0
    """How many elastic modes the model has at this posture."""
    free_motions: tuple[str, ...] = ()
    """Motions of the tool that nothing holds, in words: modes of frequency zero."""
    idle_motions: tuple[str, ...] = ()
    """Motions of inner parts only, in words."""
    rules: Mapping[str, str] = field(default_factory=dict)
    """How the mass of each link and of the tool was distributed."""
    notes: tuple[str, ...] = ()
    """What a reader should know besides."""
    drawing: ModesDrawing | None = None
    """The mechanism at rest and in each mode; None where there is no mode."""

    @property
    def frequencies_hz(self) -> Array:
        """(n,), ascending."""
        return np.array([mode.frequency_hz for mode in self.modes])

    def as_json(self) -> dict[str, Any]:
        """Return plain data for JSON; what is not a finite number is null."""
        return {
            "robot": self.robot,
            "model": self.model,
            "status": self.status.word,
            "reason": self.reason or None,
            "pose": dict(zip(DIRECTIONS, plain(self.tool), strict=True)),
            "frequencies_hz": plain(self.frequencies_hz),
            "modes": [mode.as_json() for mode in self.modes],
            "n_existing": self.n_existing,
            "free_motions": list(self.free_motions),
            "idle_motions": list(self.idle_motions),
            "rules": dict(self.rules),
            "notes": list(self.notes),
            "units": {"pose": "m, rad", "modes.tool": "m, rad at unit modal mass (kg m^2)"},
        }


def analyse_modes(
    robot: Robot | Analysis,
    at: Mapping[str, float] | None = None,
    n: int = 4,
    *,
    model: VibrationModel = "refined",
    n_elements: int | None = None,
) -> ModesResult:
    """Return the lowest ``n`` elastic modes at one tool pose.

    ``at`` names tool coordinates (m, rad); independent ones that are missing are the home
    posture's. ``n_elements`` is how many elements each link is cut into; by default 8 consistent
    ones, reduced to the ports and six modes of each link, or 20 rigid ones. Raises PoseError for
    numbers or coordinates that do not fit the robot, LinkError where there is no mass or a link's
    mass cannot be distributed, AssemblyError if the robot cannot be put together.
    """
    at = at or {}
    how = _discretisation(model, n_elements)
    if n < 1:
        raise PoseError(f"{n} modes were asked for", mend="ask for one at least")
    analysis = robot if isinstance(robot, Analysis) else Analysis(robot, prefer=at)
    if model == "lumped-eq25" and how is not None:
        analysis = Analysis(struck_robot(analysis.robot, how.n_elements), prefer=at)
    modal = _modal_model(analysis, how)
    postures = analysis.kinematics.solve_at(at)
    if not postures.reached[0]:
        return ModesResult(
            analysis.robot.name,
            analysis.robot.title,
            model,
            Status.UNREACHABLE,
            out_of_reach(analysis, at),
            np.full(6, np.nan),
        )
    return _result(analysis, model, modal, postures, n)


def _discretisation(model: VibrationModel, n_elements: int | None) -> Discretisation | None:
    """Return how links are cut up, None in the simplified model."""
    if model == "simplified":
        if n_elements is not None:
            raise PoseError(
                "the simplified model has no elements: its links are rigid and have no mass",
                mend="leave the number of elements out, or take another model",
            )
        return None
    is_lumped = model.startswith("lumped")
    # A struck spring needs a body on its other side that is no port.
    fewest = {"lumped": 2, "lumped-eq25": 4}.get(model, 1)
    if n_elements is not None and n_elements < fewest:
        raise PoseError(
            f"{n_elements} elements of each link are too few for the {model} model",
            mend=f"ask for {fewest} at least",
        )
    if is_lumped:
        return Discretisation("lumped", n_elements or LUMPED_ELEMENTS, None)
    # Who asks for a number of elements wants to see what they do, without another reduction.
    return (
        Discretisation() if n_elements is None else Discretisation("consistent", n_elements, None)
    )


def _modal_model(analysis: Analysis, how: Discretisation | None) -> ModalModel:
    kinematics = analysis.kinematics
    if how is None:
        return simplified_modes(kinematics.tree, kinematics.length)
    modal = ModalModel(kinematics.tree, kinematics.length, how)
    if not (modal.bodies.rigid or modal.bodies.elastic or modal.bodies.tool_mass):
        raise LinkError(
            f"{analysis.robot.name} has no mass anywhere, so nothing can vibrate",
            mend="give links a mass or a material, or the tool a mass:"
            "  tool: {at: ..., mass: 5 kg}",
        )
    return modal


def _result(
    analysis: Analysis, model: VibrationModel, modal: ModalModel, postures: Postures, n: int
) -> ModesResult:
    q, tool = postures.coordinates[:, 0], postures.tool[:, 0]
    found = modal.at(q, n)
    drawing = draw_modes(modal, q, found) if found.frequencies_hz.size else None
    free = tuple(analysis.words(motion, tool) for motion in found.free_motions)
    status = _status(analysis, model) if free else Status.OK
    return ModesResult(
        robot=analysis.robot.name,
        title=analysis.robot.title,
        model=model,
        status=status,
        reason="" if not free else f"{_MEANING[status]}: {'; '.join(free)}",
        tool=tool,
        modes=() if drawing is None else _modes(found, drawing, modal.length),
        n_existing=found.n_existing,
        free_motions=free,
        idle_motions=tuple(analysis.words(motion, tool) for motion in found.idle_motions),
        rules=_rules(analysis.robot, modal, model),
        notes=tuple(_notes(analysis.robot, found, n, model)),
        drawing=drawing,
    )


_MEANING = {
    Status.SINGULAR: "the posture is singular",
    Status.UNCONTROLLED: "the robot does not hold its tool",
}


def _status(analysis: Analysis, model: VibrationModel) -> Status:
    """Return what a free motion of the tool means: of this posture, or of the robot."""
    stiffness = analysis.model("simplified" if model == "simplified" else "refined")
    return Status.UNCONTROLLED if stiffness.uncontrolled else Status.SINGULAR


def _modes(found: Modes, drawing: ModesDrawing, length: float) -> tuple[Mode, ...]:
    rows = zip(
        found.frequencies_hz, found.tool.T, drawing.tool_shares, found.energy_shares, strict=True
    )
    return tuple(
        Mode(
            float(frequency),
            describe_mode(twist, drawing.tool, length, float(share), energy),
            twist,
            energy,
        )
        for frequency, twist, share, energy in rows
    )


def _rules(robot: Robot, modal: ModalModel, model: VibrationModel) -> dict[str, str]:
    """Return in words how the mass of each link, and of the tool, was distributed."""
    rules: dict[str, str] = {}
    for name, link in robot.links.items():
        if name in modal.bodies.elastic:
            rules[name] = f"{link.mass:.6g} kg: {modal.bodies.elastic[name].rule}"
        elif name in modal.bodies.rigid:
            rules[name] = f"{link.mass:.6g} kg: rigid body"
        elif model == "simplified":
            rules[name] = "rigid, and its mass left out, as in all simplified models"
        else:
            rules[name] = f"no mass given: {'rigid' if link.compliance is None else 'a spring'}"
    if modal.bodies.tool_mass:
        rules["tool point"] = f"{modal.bodies.tool_mass:.6g} kg: point mass"
    return rules


def _notes(robot: Robot, found: Modes, n: int, model: VibrationModel) -> list[str]:
    notes = []
    if found.n_existing == 0:
        notes.append("there is no elastic mode: no mass moves against a spring")
    elif found.n_existing < n:
        count = "1 mode" if found.n_existing == 1 else f"{found.n_existing} modes"
        notes.append(f"{n} modes were asked for, and the {model} model has {count} here")
    forgotten = [k.name for k in robot.links.values() if k.inertia is not None and not k.mass]
    if forgotten and model != "simplified":
        notes.append(f"an inertia without a mass counts for nothing: {', '.join(forgotten)}")
    return notes
