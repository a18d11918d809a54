"""The command that looks for better dimensions."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stiffkit.cli.arguments import json_option

if TYPE_CHECKING:
    import xarray as xr

    from stiffkit.progress import Progress

_POINTS_OF_A_MAP = 2000


@click.command()
@click.argument("design_file", metavar="STUDY", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=True),
    default=None,
    help="Directory for the study; by default stiffkit-NAME here. One that is there is gone on "
    "with.",
)
@click.option(
    "--robot",
    "robots",
    type=click.IntRange(min=0),
    multiple=True,
    metavar="NUMBER",
    help="Write the robot file of this design, as DIR/design-NUMBER.yaml. Repeatable.",
)
@click.option("--report/--no-report", default=True, help="Draw figures and write a report, or not.")
@json_option
def design(
    design_file: Path, output: Path | None, robots: tuple[int, ...], report: bool, as_json: bool
) -> None:
    """Look for better dimensions of a robot.

    STUDY is a YAML file: a robot, the parameters that are free, objectives and constraints. Writes
    all designs that were looked at as DIR/designs.nc, the robot file of the best one by each model,
    and a report. A study that is interrupted, whatever by, goes on with the same command.

    Example:  stiffkit design stiffer.yaml -o out/stiffer
    """
    from stiffkit.cli.show import progress
    from stiffkit.cli.show_design import designs_as_json, show_designs
    from stiffkit.design import read_design, run_design, write_design_robot

    spec = read_design(design_file)
    target = output or Path(f"stiffkit-{design_file.stem}")
    try:
        with progress(sys.stderr.isatty()) as tell:
            designs = run_design(spec, target, progress=tell)
            files = {f"design-{number}.yaml": number for number in robots}
            for model, number in json.loads(designs.attrs["chosen"]).items():
                files[f"best-{model}.yaml"] = number
            for name, number in files.items():
                write_design_robot(designs, number, target / name)
            if report:
                _write_report(designs, target, tell)
    except KeyboardInterrupt:
        click.echo(
            "interrupted; what is finished is kept, and the same command goes on with it", err=True
        )
        sys.exit(130)
    if as_json:
        click.echo(json.dumps(designs_as_json(designs, target), indent=1, allow_nan=False))
        return
    show_designs(designs)
    click.echo(f"designs: {target / 'designs.nc'}")
    for name in files:
        click.echo(f"robot file: {target / name}")
    if report:
        click.echo(f"open {target / 'report.html'}")


def _write_report(designs: xr.Dataset, target: Path, tell: Progress) -> None:
    """Write figures and report, with maps of the start and of the best design."""
    from stiffkit.design import map_design
    from stiffkit.report import write_design_report

    chosen = json.loads(designs.attrs["chosen"])
    maps = {}
    if chosen and next(iter(chosen.values())) != 0:
        shown = {"start": 0, "chosen": next(iter(chosen.values()))}
        maps = {n: map_design(designs, i, _POINTS_OF_A_MAP, tell) for n, i in shown.items()}
    tell("writing the report", 1.0)
    write_design_report(designs, target, maps or None)
