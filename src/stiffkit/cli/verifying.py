"""The command that proves a robot's reduced model by finite elements of the whole robot."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from pathlib import Path

import click

from stiffkit.cli.arguments import (
    RobotArgument,
    json_option,
    output_option,
    parameter_option,
    set_values,
    tool_pose,
)
from stiffkit.errors import PoseError


@click.command()
@click.argument("robot", type=RobotArgument())
@click.option(
    "--at",
    multiple=True,
    metavar="x=...,y=...",
    help="Tool coordinates of a posture, as in the command pose; by default the home posture. "
    "Repeatable: parts are meshed once for all postures.",
)
@click.option(
    "-n",
    "n_modes",
    type=click.IntRange(min=0, max=20),
    default=4,
    show_default=True,
    help="How many natural frequencies are compared, lowest first.",
)
@click.option(
    "--size",
    default=None,
    metavar="LENGTH",
    help="Largest element, such as 8mm; by default the "
    "meshes that the links themselves were solved on.",
)
@click.option(
    "--order",
    type=click.IntRange(min=1, max=8),
    default=None,
    help="Order of the elements; by default that of each link, or lower where the whole would be "
    "too large.",
)
@click.option("--allow-overlap", is_flag=True, help="Go on where parts overlap.")
@click.option("--allow-gaps", is_flag=True, help="Go on where interfaces of a joint do not meet.")
@json_option
@output_option("Directory for verify.json.")
@parameter_option
def verify(
    robot: str,
    at: tuple[str, ...],
    n_modes: int,
    size: str | None,
    order: int | None,
    allow_overlap: bool,
    allow_gaps: bool,
    as_json: bool,
    output: Path | None,
    settings: tuple[str, ...],
) -> None:
    """Compare the reduced model at given postures with finite elements of the whole robot.

    All parts are meshed, tied by the robot's joints as their interfaces say, and solved as one
    sparse system, with nothing reduced. Compliance is compared element by element, and with it the
    lowest natural frequencies. Every elastic link must be given by CAD.

    Example:  stiffkit verify biglide-cad --at x=0.4975,y=0
    """
    postures, largest = [tool_pose((one,)) for one in at], _size(size)
    given = set_values(settings)
    from stiffkit.cli.show import progress, tell, write_json
    from stiffkit.cli.show_verified import show_verification
    from stiffkit.robot import load_robot
    from stiffkit.study import VERIFICATION, whole_directory
    from stiffkit.verify import Resolution, Verification, verify_postures

    target = nullcontext() if output is None else whole_directory(output, VERIFICATION)
    with target as work, progress(sys.stderr.isatty()) as report:
        found = verify_postures(
            load_robot(robot, given, report),
            postures or [{}],
            n_modes=n_modes,
            resolution=Resolution(largest, order),
            allow_overlap=allow_overlap,
            allow_gaps=allow_gaps,
            progress=report,
        )
        if work is not None:
            write_json(work / "verify.json", found.as_json())
    written = [] if output is None else [f"verify.json in {output}"]
    tell(found, show_verification, Verification.as_json, as_json=as_json, written=written)


def _size(text: str | None) -> float | None:
    """Return the size of elements, m."""
    from stiffkit.units import LENGTH, to_si

    if text is None:
        return None
    size = to_si(text, LENGTH)
    if not size > 0.0:
        raise PoseError(f"elements of {text} cannot be", mend="give a positive --size, such as 8mm")
    return size
