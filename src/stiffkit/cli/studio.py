"""The command that opens the studio in the browser."""

from __future__ import annotations

import sys
import webbrowser
from pathlib import Path

import click

from stiffkit.cli.arguments import RobotArgument, parameter_option, set_values


@click.command()
@click.argument("robot", type=RobotArgument())
@click.option(
    "--folder",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path(),
    help="Where the studio saves robot files, pictures and reports; by default here. It writes "
    "nowhere else.",
)
@click.option(
    "--points",
    type=click.IntRange(min=1, max=1_000_000),
    default=None,
    help="About how many poses of the workspace; by default what the robot file asks for, at most "
    "10000.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=8090, show_default=True)
@click.option(
    "--host",
    default="127.0.0.1",
    show_default=True,
    help="Address to listen at. By default only this computer reaches the studio; whoever reaches "
    "it can use all of it, without a password.",
)
@click.option("--open/--no-open", "opens", default=True, help="Open the page in the browser.")
@parameter_option
def studio(
    robot: str,
    folder: Path,
    points: int | None,
    port: int,
    host: str,
    opens: bool,
    settings: tuple[str, ...],
) -> None:
    """See a robot in the browser: drag its tool, move its dimensions, and watch the map follow.

    The mechanism in 3D, how it bends under load and vibrates, stiffness ellipsoids, the compliance,
    and any quantity over the whole workspace, all computed anew as you move. Ends with Ctrl+C.

    Example:  stiffkit studio biglide
    """
    given = set_values(settings)
    from stiffkit.cli.show import progress
    from stiffkit.studio import open_studio

    with progress(sys.stderr.isatty()) as tell:
        running = open_studio(
            robot, given, folder=folder, points=points, host=host, port=port, progress=tell
        )
    click.echo(f"{running.title} at {running.address}")
    click.echo(f"saves into {folder.resolve()}; end with Ctrl+C")
    if opens:
        webbrowser.open(running.address)
    try:
        running.wait()
    except KeyboardInterrupt:
        click.echo("closed")
    finally:
        running.close()
