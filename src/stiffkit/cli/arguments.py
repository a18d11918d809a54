"""Command-line text to numbers."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from stiffkit.errors import PoseError

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy as np
    from numpy.typing import NDArray

    from stiffkit.robot import Robot

WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")

json_option = click.option(
    "--json", "as_json", is_flag=True, help="Print JSON (SI units) instead of text."
)


def output_option(what: str) -> Callable[[Any], Any]:
    """Return the option -o for the path of what a command writes, in words."""
    return click.option("-o", "--output", type=click.Path(path_type=Path), default=None, help=what)


def set_option(what: str, example: str) -> Callable[[Any], Any]:
    """Return the option --set, which replaces ``what``."""
    return click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="NAME=VALUE",
        help=f"Replace {what}, such as --set {example}. Repeatable.",
    )


parameter_option = set_option("a parameter of the robot file", "L1=900mm")


def set_values(settings: tuple[str, ...]) -> dict[str, str]:
    """Return the values of ``--set NAME=VALUE`` by name."""
    return assignments(",".join(settings), "--set")


def results_folder(name: str, output: Path | None, *, as_json: bool) -> Path | None:
    """Return where results go: stiffkit-NAME here if nothing is said, and nowhere for JSON."""
    return Path(f"stiffkit-{name}") if output is None and not as_json else output


def assignments(text: str, option: str) -> dict[str, str]:
    """Return the parts of ``name=value,name=value``."""
    parts: dict[str, str] = {}
    for part in filter(None, (p.strip() for p in text.split(","))):
        name, equals, value = (piece.strip() for piece in part.partition("="))
        if not equals or not name or not value:
            raise PoseError(
                f"'{part}' in {option} is not of the form name=value",
                mend=f"write for example  {option} x=0.4975,y=-20mm",
            )
        if name in parts:
            raise PoseError(f"'{name}' is given twice in {option}", mend="keep one of them")
        parts[name] = value
    return parts


def tool_pose(texts: tuple[str, ...]) -> dict[str, float]:
    """Return tool coordinates (m, rad) of ``--at x=0.4975,y=-20mm,rz=10deg``."""
    from stiffkit.files.names import suggest
    from stiffkit.robot import DIRECTIONS
    from stiffkit.units import ANGLE, LENGTH, to_si

    at: dict[str, float] = {}
    for name, value in assignments(",".join(texts), "--at").items():
        if name not in DIRECTIONS:
            raise PoseError(
                f"'{name}' is no tool coordinate",
                mend=suggest(name, DIRECTIONS),
            )
        at[name] = to_si(value, ANGLE if name.startswith("r") else LENGTH)
    return at


def load_cases(texts: tuple[str, ...], robot: Robot) -> dict[str, NDArray[np.float64]] | None:
    """Return wrenches (6,) of ``--load NAME`` or ``--load fz=1000,mx=2Nm``; None for the file's."""
    import numpy as np

    from stiffkit.files.names import suggest
    from stiffkit.units import FORCE, MOMENT, to_si

    if not texts:
        return None
    loads: dict[str, NDArray[np.float64]] = {}
    for text in texts:
        if "=" not in text:
            if text not in robot.loads:
                raise PoseError(
                    f"{robot.name} has no load case '{text}'",
                    mend=f"{suggest(text, robot.loads)}; or give one as  --load fz=1000,mx=2Nm",
                )
            loads[text] = robot.loads[text].wrench
            continue
        wrench = np.zeros(6)
        for name, value in assignments(text, "--load").items():
            if name not in WRENCH:
                raise PoseError(
                    f"'{name}' is no component of a load",
                    mend=suggest(name, WRENCH),
                )
            wrench[WRENCH.index(name)] = to_si(value, MOMENT if name[0] == "m" else FORCE)
        loads[text] = wrench
    return loads


class RobotArgument(click.ParamType):  # type: ignore[type-arg]  # generic only for checkers
    """A robot file, or the name of a robot in the catalogue."""

    name = "robot"

    def shell_complete(
        self,
        ctx: click.Context,
        param: click.Parameter,
        incomplete: str,
    ) -> list[click.shell_completion.CompletionItem]:
        """Offer the catalogue's names, or else files."""
        del ctx, param
        from stiffkit.robot import list_robots

        names = [n for n in list_robots() if n.startswith(incomplete)]
        items = [click.shell_completion.CompletionItem(n) for n in names]
        # In bash, click's script forgets what stands before the item that asks for files.
        return [click.shell_completion.CompletionItem(incomplete, type="file"), *items]
