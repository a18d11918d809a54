"""The commands.

Heavy rooms are imported inside them, so that help appears at once, and after what the user typed
has been read, so that a slip is told at once.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stiffkit import __version__
from stiffkit.cli.arguments import (
    RobotArgument,
    json_option,
    load_cases,
    output_option,
    parameter_option,
    set_values,
    tool_pose,
)
from stiffkit.cli.designing import design
from stiffkit.cli.identifying import advise, identify
from stiffkit.cli.linking import link
from stiffkit.cli.parts import parts
from stiffkit.cli.reproducing import reproduce
from stiffkit.cli.studio import studio
from stiffkit.cli.studying import study
from stiffkit.cli.uncertain import uncertainty
from stiffkit.cli.verifying import verify
from stiffkit.errors import PoseError

if TYPE_CHECKING:
    from stiffkit.robot import Robot
    from stiffkit.study import ModesResult

_robot = click.argument("robot", type=RobotArgument())
_at = click.option(
    "--at",
    multiple=True,
    metavar="x=...,y=...",
    help="Tool coordinates x, y, z and rotation vector rx, ry, rz; bare numbers are m and rad, "
    "units as in x=497.5mm,rz=10deg. Those not given are the home posture's, or follow from the "
    "mechanism.",
)


def _load(robot: str, settings: tuple[str, ...]) -> Robot:
    from stiffkit.cli.show import progress
    from stiffkit.robot import load_robot

    given = set_values(settings)
    with progress(sys.stderr.isatty()) as report:
        return load_robot(robot, given, report)


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="A first look:  stiffkit robots, then  stiffkit map biglide",
)
@click.version_option(__version__, "-V", "--version", prog_name="stiffkit")
def main() -> None:
    """Stiffness and vibration of parallel robots over their whole workspace.

    ROBOT is a robot file (YAML) or the name of a robot in the catalogue.
    """


main.add_command(design)
main.add_command(identify)
main.add_command(advise)
main.add_command(link)
main.add_command(parts)
main.add_command(reproduce)
main.add_command(studio)
main.add_command(study)
main.add_command(uncertainty)
main.add_command(verify)


@main.command()
def robots() -> None:
    """List the robots of the catalogue.

    Example:  stiffkit robots
    """
    from stiffkit.robot import describe_robots

    found = describe_robots()
    width = max(len(robot.name) for robot in found)
    for robot in found:
        click.echo(f"{robot.name:<{width}}  {robot.title}")


@main.command()
@_robot
@parameter_option
def check(robot: str, settings: tuple[str, ...]) -> None:
    """Read a robot file, put the robot together and say what it is.

    Bodies, loops, mobility (counted, and numeric at the home posture), degree of over-constraint,
    free motions and warnings, and whether a few postures over the workspace are within reach.

    Example:  stiffkit check biglide
    """
    loaded = _load(robot, settings)
    from stiffkit.cli.show import show_notes, show_summary
    from stiffkit.study import Analysis, probe_workspace, summarise

    analysis = Analysis(loaded)
    show_summary(summarise(analysis))
    show_notes(probe_workspace(analysis))


@main.command()
@_robot
@_at
@click.option(
    "--load",
    multiple=True,
    metavar="LOAD",
    help="A load case of the file by name, or fx=...,fy=...,fz=...,mx=...,my=...,mz=... in N and "
    "N m. Repeatable; without it, all load cases of the file.",
)
@click.option(
    "--model",
    type=click.Choice(["refined", "simplified"]),
    default="refined",
    show_default=True,
    help="refined: links, joints and drives are elastic; simplified: drives only.",
)
@json_option
@parameter_option
def pose(
    robot: str,
    at: tuple[str, ...],
    load: tuple[str, ...],
    model: str,
    as_json: bool,
    settings: tuple[str, ...],
) -> None:
    """Stiffness, compliance and deflections at one tool pose.

    Example:  stiffkit pose biglide --at x=0.4975,y=0 --load fz=1000
    """
    loaded = _load(robot, settings)
    coordinates, loads = tool_pose(at), load_cases(load, loaded)
    from stiffkit.cli.show import show_pose, tell
    from stiffkit.study import PoseResult, analyse_pose

    result = analyse_pose(
        loaded,
        coordinates,
        model="simplified" if model == "simplified" else "refined",
        loads=loads,
    )
    tell(result, show_pose, PoseResult.as_json, as_json=as_json)


@main.command()
@_robot
@_at
@click.option(
    "-n",
    "n_modes",
    type=click.IntRange(min=1),
    default=4,
    show_default=True,
    help="How many modes, lowest first.",
)
@click.option(
    "--model",
    type=click.Choice(["refined", "lumped", "lumped-eq25", "simplified"]),
    default="refined",
    show_default=True,
    help="refined: links as beam elements; lumped: links as rigid elements joined by springs; "
    "lumped-eq25: the same with passive joints as eq. 25 of Briot et al. 2009 makes them, for "
    "comparison; simplified: drives and the platform's mass only.",
)
@click.option(
    "--elements",
    type=click.IntRange(min=1, max=200),
    default=None,
    help="Elements of each link; by default 8 beam elements, or 20 rigid ones. Many take long.",
)
@json_option
@output_option(
    "Directory for modes.html, an animation that needs no network, and modes/, a figure of "
    "each mode as SVG and PNG."
)
@parameter_option
def modes(
    robot: str,
    at: tuple[str, ...],
    n_modes: int,
    model: str,
    elements: int | None,
    as_json: bool,
    output: Path | None,
    settings: tuple[str, ...],
) -> None:
    """Natural frequencies and mode shapes at one tool pose.

    Example:  stiffkit modes biglide --at x=0.4975,y=0 -n 6 -o out/modes
    """
    loaded = _load(robot, settings)
    coordinates = tool_pose(at)
    from stiffkit.cli.show import show_modes, tell
    from stiffkit.study import MODELS_OF_VIBRATION, ModesResult, analyse_modes

    chosen = next(name for name in MODELS_OF_VIBRATION if name == model)
    result = analyse_modes(loaded, coordinates, n_modes, model=chosen, n_elements=elements)
    if output is not None:
        _write_modes(result, output)
    written = [] if output is None else [f"open {output / 'modes.html'}"]
    tell(result, show_modes, ModesResult.as_json, as_json=as_json, written=written)


def _write_modes(result: ModesResult, output: Path) -> None:
    """Write the animation and the figures of modes. Raises PoseError if there are none."""
    if result.drawing is None:
        raise PoseError(
            f"there is no mode to draw: {result.reason or '; '.join(result.notes)}",
            mend="leave -o out to see what else is known of the posture",
        )
    from stiffkit.plots import write_mode_figures
    from stiffkit.report import write_modes_page
    from stiffkit.study import MODES, whole_directory

    with whole_directory(output, MODES) as work:
        words = [mode.description for mode in result.modes]
        write_mode_figures(result.drawing, result.frequencies_hz, words, work / "modes")
        write_modes_page(result, work / "modes.html")


@main.command(name="map")
@_robot
@output_option("Directory for the results; by default stiffkit-NAME here.")
@click.option(
    "--points",
    type=click.IntRange(min=1, max=100_000_000),
    default=None,
    help="About how many postures; by default what the robot file asks for, else a quick map.",
)
@click.option(
    "--threads",
    type=click.IntRange(min=1, max=1024),
    default=None,
    help="How many threads compute; by default STIFFKIT_THREADS, else all processors.",
)
@click.option("--report/--no-report", default=True, help="Draw figures and write a report, or not.")
@parameter_option
def map_(
    robot: str,
    output: Path | None,
    points: int | None,
    threads: int | None,
    report: bool,
    settings: tuple[str, ...],
) -> None:
    """Stiffness over the whole workspace: dataset, figures and an interactive report.

    Writes map.nc (or map.zarr if large), figures/ as SVG and PNG, and report.html, which needs no
    network. Both models are computed.

    Example:  stiffkit map biglide -o out/biglide --points 10000
    """
    loaded = _load(robot, settings)
    from stiffkit.cli.show import progress
    from stiffkit.report import write_map
    from stiffkit.study import Analysis

    target = output or Path(f"stiffkit-{loaded.name}")
    with progress(sys.stderr.isatty()) as tell:
        written = write_map(
            Analysis(loaded), target, points=points, threads=threads, report=report, progress=tell
        )
    for sentence in written.sentences:
        click.echo(sentence)
    whole = f"Dataset, report and {written.n_figures} figures" if report else "Dataset"
    click.echo(f"{whole} in {target}")
    for warning in written.summary.warnings:
        click.echo(f"note: {warning}")
    if report:
        click.echo(f"open {target / 'report.html'}")


@main.command()
@click.argument(
    "kind",
    type=click.Choice(["robot", "link", "identify", "cad", "study", "design", "uncertainty"]),
    default="robot",
)
def schema(kind: str) -> None:
    """Print the JSON Schema of robot files, link files or specifications, for editors.

    Specifications are those of identifications (identify), of links from CAD (cad), of long
    studies (study), of design studies (design) and of studies of uncertainty (uncertainty).

    Example:  stiffkit schema > robot.schema.json
    """
    from importlib.resources import files

    room = {"cad": "fea", "uncertainty": "design.uncertainty"}.get(kind, kind)
    text = files(f"stiffkit.{room}").joinpath("schema.json").read_text(encoding="utf-8")
    click.echo(text, nl=False)


@main.command()
@click.argument("shell", type=click.Choice(["bash", "zsh", "fish"]))
def completion(shell: str) -> None:
    """Print the script that completes commands, options and robots in a shell.

    Example:  eval "$(stiffkit completion bash)"
    """
    from click.shell_completion import get_completion_class

    kind = get_completion_class(shell)
    if kind is None:
        raise click.UsageError(f"no completion for {shell}")
    click.echo(kind(main, {}, "stiffkit", "_STIFFKIT_COMPLETE").source())
