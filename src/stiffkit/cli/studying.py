"""The commands about long studies."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from stiffkit.cli.arguments import json_option, output_option

if TYPE_CHECKING:
    from stiffkit.study.sweep import Column, Executor, StudyDirectory

_directory = click.argument("directory", metavar="DIR", type=click.Path(path_type=Path))
_workers = click.option(
    "--workers",
    type=click.IntRange(min=1, max=1024),
    default=None,
    help="So many processes on this machine; by default everything happens in this one.",
)
_cluster = click.option(
    "--cluster",
    metavar="tcp://HOST:PORT",
    default=None,
    help="The workers of a Dask scheduler, which has the same version of stiffkit installed.",
)
_by = click.option(
    "--by",
    metavar="COLUMN",
    default=None,
    help="The result by which the best and worst geometries are shown; the first if left out.",
)


@click.group()
def study() -> None:
    """Long studies: many geometries of a robot, reduced to a table.

    A study that is interrupted, whatever by, goes on with 'stiffkit study resume DIR'.
    """


@study.command()
@click.argument("study_file", metavar="STUDY", type=click.Path(path_type=Path))
@output_option("Directory for the study; by default stiffkit-NAME here.")
@_workers
@_cluster
@click.option(
    "--chunk",
    type=click.IntRange(min=1),
    default=None,
    help="Geometries of a chunk, which is computed and kept as a whole; by default a few seconds' "
    "work. The numbers do not depend on it.",
)
@_by
@json_option
def run(
    study_file: Path,
    output: Path | None,
    workers: int | None,
    cluster: str | None,
    chunk: int | None,
    by: str | None,
    as_json: bool,
) -> None:
    """Run a study, or go on with it.

    STUDY is a YAML file: a robot, the parameters to vary, and the statistics to tabulate. Writes
    the table as DIR/table.nc.

    Example:  stiffkit study run legs.yaml -o out/legs --workers 4
    """
    from stiffkit.cli.show import progress
    from stiffkit.cli.show_study import chosen_column
    from stiffkit.study.sweep import create_study, read_study

    spec = read_study(study_file)
    column = chosen_column(spec, by)
    executor = _executor(workers, cluster)
    target = output or Path(f"stiffkit-{study_file.stem}")
    with progress(sys.stderr.isatty()) as report:
        report("preparing", 0.0)
        directory = create_study(target, spec, chunk_size=chunk)
    _run(directory, executor, column, as_json)


@study.command()
@_directory
@_workers
@_cluster
@_by
@json_option
def resume(
    directory: Path, workers: int | None, cluster: str | None, by: str | None, as_json: bool
) -> None:
    """Go on with a study that was interrupted.

    Example:  stiffkit study resume out/legs
    """
    from stiffkit.cli.show_study import chosen_column
    from stiffkit.study.sweep import open_study

    found = open_study(directory)
    column = chosen_column(found.spec, by)
    _run(found, _executor(workers, cluster), column, as_json)


@study.command()
@_directory
@json_option
def status(directory: Path, as_json: bool) -> None:
    """Tell how far a study is.

    Example:  stiffkit study status out/legs
    """
    from stiffkit.cli.show import tell
    from stiffkit.cli.show_study import show_status, status_as_json
    from stiffkit.study.sweep import open_study

    tell(open_study(directory), show_status, status_as_json, as_json=as_json)


def _executor(workers: int | None, cluster: str | None) -> Executor:
    from stiffkit.study.sweep import Cluster, InProcess, Processes

    if workers is not None and cluster is not None:
        raise click.UsageError("--workers and --cluster exclude each other")
    if cluster is not None:
        return Cluster(cluster, lambda text: click.echo(text, err=True))
    return InProcess() if workers is None else Processes(workers)


def _run(directory: StudyDirectory, executor: Executor, column: Column, as_json: bool) -> None:
    from stiffkit.cli.show import progress, tell
    from stiffkit.cli.show_study import show_table, table_as_json
    from stiffkit.study.sweep import run_study

    try:
        with progress(sys.stderr.isatty()) as report:
            table = run_study(directory, executor, report)
    except KeyboardInterrupt:
        kept = len(directory.finished())
        click.echo(
            f"interrupted; {kept} of {directory.n_chunks} chunks are kept. Go on with:"
            f" stiffkit study resume {directory.path}",
            err=True,
        )
        sys.exit(130)
    show = partial(show_table, directory, column=column)
    plain = partial(table_as_json, directory, column=column)
    tell(table, show, plain, as_json=as_json, written=[f"table: {directory.table}"])
