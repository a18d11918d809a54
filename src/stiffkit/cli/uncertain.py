"""The command about what error bars do to a robot."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from stiffkit.cli.arguments import json_option, output_option, results_folder


@click.command()
@click.argument("study_file", metavar="STUDY", type=click.Path(path_type=Path))
@output_option("Directory for the results; by default stiffkit-NAME here, and none with --json.")
@json_option
def uncertainty(study_file: Path, output: Path | None, as_json: bool) -> None:
    """What error bars of dimensions, drives and links do to stiffness, over the workspace.

    STUDY is a YAML file: a robot, and what about it is uncertain. Prints quantities with their
    bands, what causes these, and which part to stiffen first. Writes uncertainty.nc, figures/ as
    SVG and PNG, and report.html, which needs no network.

    Example:  stiffkit uncertainty workshop.yaml -o out/workshop
    """
    from contextlib import nullcontext

    from stiffkit.cli.show import progress, tell
    from stiffkit.cli.show_uncertainty import show_uncertainty, uncertainty_as_json
    from stiffkit.design.uncertainty import (
        DATASET,
        UNCERTAINTY,
        read_uncertainty,
        run_uncertainty,
    )
    from stiffkit.study import whole_directory

    spec = read_uncertainty(study_file)
    target = results_folder(study_file.stem, output, as_json=as_json)
    place = nullcontext() if target is None else whole_directory(target, UNCERTAINTY)
    with place as work, progress(sys.stderr.isatty()) as report:
        found = run_uncertainty(spec, report)
        if work is not None:
            report("drawing figures", 1.0)
            from stiffkit.plots import write_uncertainty_figures
            from stiffkit.report import write_uncertainty_page

            (work / DATASET).write_bytes(found.to_netcdf(engine="h5netcdf"))
            figures = write_uncertainty_figures(found, work / "figures")
            report("writing the report", 1.0)
            write_uncertainty_page(found, figures, work / "report.html")
    written = (
        [] if target is None else [f"dataset: {target / DATASET}", f"open {target / 'report.html'}"]
    )
    tell(found, show_uncertainty, uncertainty_as_json, as_json=as_json, written=written)
