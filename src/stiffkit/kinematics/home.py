"""Putting the mechanism together at its home posture."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from stiffkit.errors import AssemblyError
from stiffkit.kinematics.closure import ClosureEquations
from stiffkit.kinematics.coordinates import joint_coordinates
from stiffkit.kinematics.numeric import NumericEquations, evaluate
from stiffkit.kinematics.tracking import CLOSED
from stiffkit.robot import DIRECTIONS, Joint
from stiffkit.smallmat import as_objects
from stiffkit.spatial import Frame, exp_rotation, log_rotation

Array = NDArray[np.float64]

_FITS = 1e-6
"""Gap in robot sizes, and turn in rad, below which things fit together."""

_TRIES = 30
"""Random starts after the one that the file gives, looking for the nearest assembly."""
_HOPELESS = 8
"""Starts without any assembly after which there is held to be none."""

_HUGE = 30.0
"""Size (m) above which a robot that cannot be put together has probably lost a unit."""

NEAR_HINTS = 0.5
"""Largest distance of a joint from its rough coordinate, rad or robot sizes."""

_SPRINGS = (0.3, 0.03, 0.0)
"""Stiffness of the springs that hold the unknowns, against residuals of order one."""

_NEAR = 0.3
"""Residual of a start from which no springs are needed."""


@dataclass(frozen=True, eq=False)
class HomePosture:
    """The assembly that was found."""

    unknowns: Array
    """(n,), SI."""
    off_by: float
    """Distance from the rough coordinates that the file gives, rad or robot sizes."""
    off_at: str
    """The joint that is furthest off, "" if the file gives none."""


def assemble(closure: ClosureEquations) -> HomePosture:
    """Return the home posture, the assembly nearest to what the file gives.

    Raises AssemblyError, which names the loops that stay open, if there is none.
    """
    home = closure.tree.robot.home
    asked = np.array([home.tool[d] for d in closure.asked])
    guess, given = _guess(closure)
    best: HomePosture | None = None
    nearest_miss: tuple[float, Array] = (np.inf, guess)
    rng = np.random.default_rng(0)
    for attempt in range(1 + _TRIES):
        away = min(attempt / _HOPELESS, 1.0)
        start = guess if attempt == 0 else _random_start(closure, guess, given, away, rng)
        unknowns, residual = _solve(closure, start, given, asked)
        if residual > CLOSED or gaps(closure, unknowns, asked):
            if residual < nearest_miss[0]:
                nearest_miss = (residual, unknowns)
            if best is None and attempt + 1 >= _HOPELESS:
                break
            continue
        found = _with_distance(closure, unknowns)
        if best is None or found.off_by < best.off_by:
            best = found
        if best.off_by < NEAR_HINTS:
            break
    if best is None:
        open_loops = gaps(closure, nearest_miss[1], asked) or "its loops close only nearly"
        raise AssemblyError(
            f"the mechanism cannot be put together at its home posture: {open_loops}",
            mend=_mend(closure),
        )
    return best


def _mend(closure: ClosureEquations) -> str:
    """Return what to do about a robot that cannot be put together."""
    if closure.length > _HUGE:
        return (
            f"the robot is {closure.length:.3g} m large: a number without a unit is in metres, so "
            "write '310 mm' or 0.31"
        )
    if not closure.tree.robot.home.joints:
        return "check lengths and joint frames, or give rough joint coordinates under 'home'"
    return "check lengths and joint frames, or choose a home posture within reach"


def _guess(closure: ClosureEquations) -> tuple[Array, NDArray[np.bool_]]:
    guess = np.zeros(closure.n_unknowns)
    given = np.zeros(closure.n_unknowns, dtype=bool)
    for tree_joint in closure.tree.joints:
        hint = closure.tree.robot.home.joints.get(tree_joint.joint.name)
        if hint is not None:
            guess[tree_joint.coordinates] = hint
            given[tree_joint.coordinates] = True
    return guess, given


def _random_start(
    closure: ClosureEquations,
    guess: Array,
    given: NDArray[np.bool_],
    away: float,
    rng: np.random.Generator,
) -> Array:
    """Return a start anywhere, but at most the share ``away`` of that from what is given."""
    spread = np.where(closure.translates, closure.length, np.pi)
    free = rng.uniform(-1.0, 1.0, guess.shape) * spread
    return np.where(given, guess + away * free, free)


def _solve(
    closure: ClosureEquations, start: Array, given: NDArray[np.bool_], asked: Array
) -> tuple[Array, float]:
    """Return the closed posture near a start, or the nearest miss, and its residual.

    Springs hold the unknowns at the start while the loops are drawn together, those that the file
    gives more than others, and are then let go; this finds a near assembly where Newton's method
    from the start alone would jump.
    """
    scales = np.where(closure.translates, closure.length, 1.0)
    if not evaluate(closure, start, asked).residuals.size:
        return start, 0.0
    unknowns = start
    far = float(np.linalg.norm(evaluate(closure, start, asked).residuals)) > _NEAR
    for spring in _SPRINGS if far else _SPRINGS[-1:]:
        springs = np.where(given, 1.0, 0.1) * spring
        unknowns = _least_squares(closure, unknowns, start, springs, scales, asked)
    turning = wraps(closure)
    unknowns[turning] = (unknowns[turning] + np.pi) % (2 * np.pi) - np.pi
    return unknowns, float(np.linalg.norm(evaluate(closure, unknowns, asked).residuals))


def _least_squares(
    closure: ClosureEquations,
    unknowns: Array,
    rest: Array,
    springs: Array,
    scales: Array,
    asked: Array,
) -> Array:
    @lru_cache(maxsize=1)
    def at(key: bytes) -> NumericEquations:
        return evaluate(closure, np.frombuffer(key) * scales, asked)

    def residuals(u: Array) -> Array:
        return np.concatenate([at(u.tobytes()).residuals, springs * (u - rest / scales)])

    def jacobian(u: Array) -> Array:
        return np.concatenate([at(u.tobytes()).jacobian, np.diag(springs)])

    tolerance = 1e-15 if not springs.any() else 1e-4
    result = least_squares(
        residuals,
        unknowns / scales,
        jac=jacobian,
        xtol=tolerance,
        ftol=tolerance,
        gtol=tolerance,
        max_nfev=60,
    )
    return np.asarray(result.x) * scales


def wraps(closure: ClosureEquations) -> NDArray[np.bool_]:
    """Tell which unknowns are angles about one axis (not components of a rotation vector)."""
    wraps = np.zeros(closure.n_unknowns, dtype=bool)
    for tree_joint in closure.tree.joints:
        wraps[tree_joint.coordinates] = tree_joint.joint.kind != "spherical"
    return wraps


def observed_frames(closure: ClosureEquations, unknowns: Array) -> tuple[Frame, dict[str, Frame]]:
    """Return T_world_tool, and T_from_to of each chord joint."""
    kernel = closure.observation()
    q = as_objects(unknowns[: closure.tree.n_coordinates])
    values = np.array(kernel.function(q, as_objects(closure.constants.values)), dtype=float)
    tool, *chords = (Frame(row[:9].reshape(3, 3), row[9:]) for row in values.reshape(-1, 12))
    names = (chord.name for chord in closure.tree.chords)
    return tool, dict(zip(names, chords, strict=True))


def _coordinates(joint: Joint, frame: Frame) -> Array:
    R, p = frame.rotation[..., None], frame.position[:, None]
    return joint_coordinates(joint, R, p)[:, 0]


def _rebuilt(joint: Joint, q: Array) -> Frame:
    if joint.kind == "spherical":
        return Frame(exp_rotation(q))
    frame = Frame()
    for motion, value in zip(joint.motions, q, strict=True):
        axis = np.eye(3)["xyz".index(motion[-1])]
        step = Frame(exp_rotation(value * axis)) if motion[0] == "r" else Frame.at(*(value * axis))
        frame = frame @ step
    return frame


def _misfit(joint: Joint, frame: Frame) -> tuple[float, float]:
    """Return how far (m) and how turned (rad) a chord's sides are from what the joint allows."""
    wanted = _rebuilt(joint, _coordinates(joint, frame))
    error = wanted.inverse @ frame
    gap = float(np.linalg.norm(error.position))
    return gap, float(np.linalg.norm(log_rotation(error.rotation)))


def _with_distance(closure: ClosureEquations, unknowns: Array) -> HomePosture:
    _, frames = observed_frames(closure, unknowns)
    found = {t.joint.name: unknowns[t.coordinates] for t in closure.tree.joints}
    found |= {chord.name: _coordinates(chord, frames[chord.name]) for chord in closure.tree.chords}
    distances = [(0.0, "")]
    for name, hint in closure.tree.robot.home.joints.items():
        motions = closure.tree.robot.joints[name].motions
        for motion, value, wanted in zip(motions, found[name], hint, strict=True):
            difference = float(value - wanted)
            if motion.startswith("r"):
                difference = (difference + np.pi) % (2 * np.pi) - np.pi
            else:
                difference /= closure.length
            distances.append((abs(difference), name))
    off_by, off_at = max(distances)
    return HomePosture(unknowns, off_by, off_at)


def gaps(closure: ClosureEquations, unknowns: Array, asked: Array) -> str:
    """Return in words where loops stay open and what the tool misses, "" if all fits.

    The equations alone do not tell: they leave out what no coordinate can change, and hold as well
    with a joint's axes, or the tool, half a turn away.
    """
    tool, frames = observed_frames(closure, unknowns)
    words = []
    for chord in closure.tree.chords:
        gap, turn = _misfit(chord, frames[chord.name])
        amounts = _amounts(gap, turn, closure.length)
        if amounts:
            left, right = closure.tree.loop(chord)
            names = [t.joint.name for t in [*left, *reversed(right)]]
            words.append(
                f"the loop {' - '.join([*names, chord.name])} stays open by"
                f" {amounts} at joint '{chord.name}'"
            )
    missed = _amounts(
        _tool_gap(closure, tool, asked), _tool_turn(closure, tool, unknowns, asked), closure.length
    )
    if missed:
        asked_names = ", ".join(d for d in DIRECTIONS if d in closure.asked)
        words.append(f"the tool misses its home coordinates {asked_names} by {missed}")
    if len(words) > 2:
        words = [*words[:2], f"and {len(words) - 2} more loops stay open"]
    return "; ".join(words)


def _amounts(gap: float, turn: float, length: float) -> str:
    amounts = []
    if gap > _FITS * length:
        amounts.append(f"{1e3 * gap:.4g} mm")
    if turn > _FITS:
        amounts.append(f"{np.degrees(turn):.4g} deg")
    return " and ".join(amounts)


def _tool_gap(closure: ClosureEquations, tool: Frame, asked: Array) -> float:
    """Return how far (m) the tool is from the position that is asked for."""
    wanted = dict(zip(closure.asked, asked, strict=True))
    places = zip("xyz", tool.position, strict=True)
    return float(np.linalg.norm([wanted[d] - x for d, x in places if d in wanted]))


def _tool_turn(closure: ClosureEquations, tool: Frame, unknowns: Array, asked: Array) -> float:
    """Return how far (rad) the tool is turned from what is asked for, if anything is."""
    given = {d: x for d, x in zip(closure.asked, asked, strict=True) if d.startswith("r")}
    if not given:
        return 0.0
    extra = unknowns[closure.tree.n_coordinates :]
    rotation = given | dict(zip(closure.auxiliary, extra, strict=True))
    w = np.array([rotation[d] for d in ("rx", "ry", "rz")])
    # Coordinates that follow could make a full turn of any one that is given.
    excess = float(np.linalg.norm(w)) - max(np.pi, float(np.linalg.norm([*given.values()])))
    turn = log_rotation(exp_rotation(w).T @ tool.rotation)
    return max(float(np.linalg.norm(turn)), excess)
