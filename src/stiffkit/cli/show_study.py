"""Long studies as text for a terminal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click
import numpy as np

from stiffkit.cli.show import heading
from stiffkit.errors import StiffkitError
from stiffkit.files.names import suggest
from stiffkit.study import QUANTITIES
from stiffkit.study.sweep import Column, StudyDirectory, StudySpec, describe

if TYPE_CHECKING:
    import xarray as xr
    from numpy.typing import NDArray

_SHOWN = 5
"""Geometries that are shown from each end."""


def chosen_column(spec: StudySpec, name: str | None) -> Column:
    """Return the column that geometries are ranked by. Raises StiffkitError if there is none."""
    columns = {column.name: column for column in spec.columns}
    if name is None:
        return spec.columns[0]
    if name not in columns:
        raise StiffkitError(f"the study has no result '{name}'", mend=suggest(name, columns))
    return columns[name]


def more_is_better(column: Column) -> bool:
    """Tell whether a larger value is the better one: stiff and fast is good, soft is bad."""
    larger = not QUANTITIES[column.quantity].worst_is_largest
    return not larger if column.statistic == "share below" else larger


def ranked(table: xr.Dataset, column: Column) -> NDArray[np.intp]:
    """Return the numbers of the geometries that have an answer, best first."""
    values = table[column.name].values[0]
    known = np.flatnonzero(np.isfinite(values))
    sign = -1.0 if more_is_better(column) else 1.0
    return known[np.argsort(sign * values[known], kind="stable")]


def show_table(directory: StudyDirectory, table: xr.Dataset, column: Column) -> None:
    """Print the best and the worst geometries of a finished study."""
    spec = directory.spec
    heading(spec.title)
    status = table["geometry_status"].values
    counts = (
        f"{spec.n_geometries} geometries, {' x '.join(map(str, directory.shape))} postures each"
    )
    without = int(np.sum(status != 0))
    click.echo(counts + (f"; {without} cannot be built or assembled" if without else ""))
    order = ranked(table, column)
    if not order.size:
        click.echo("no geometry has a result")
        return
    click.echo(f"by {column.name}: {describe(column)}, {spec.models[0]} model")
    names = [v.name for v in spec.varied] + [c.name for c in spec.columns]
    widths = [max(12, len(name) + 2) for name in names]
    click.echo(
        "".join(f"{n:>{w}}" for n, w in zip(["geometry", *names], [9, *widths], strict=True))
    )
    units = [str(table[name].attrs["units"]) for name in names]
    click.echo("".join(f"{u:>{w}}" for u, w in zip(["", *units], [9, *widths], strict=True)))
    both = order.size > 2 * _SHOWN
    for i in order[:_SHOWN] if both else order:
        _show_row(table, int(i), names, widths)
    if both:
        click.echo(f"{'...':>9}")
        for i in order[-_SHOWN:]:
            _show_row(table, int(i), names, widths)


def _show_row(table: xr.Dataset, i: int, names: list[str], widths: list[int]) -> None:
    cells = [f"{i:>9}"]
    for name, width in zip(names, widths, strict=True):
        cells.append(f"{float(table[name].values[..., i].ravel()[0]):>{width}.5g}")
    click.echo("".join(cells))


def table_as_json(directory: StudyDirectory, table: xr.Dataset, column: Column) -> dict[str, Any]:
    """Return what `show_table` prints as plain data, SI."""
    order = ranked(table, column)
    return {
        "directory": str(directory.path),
        "table": str(directory.table),
        "geometries": directory.spec.n_geometries,
        "without_result": int(np.sum(table["geometry_status"].values != 0)),
        "by": column.name,
        "best": [_row(directory, table, int(i)) for i in order[:_SHOWN]],
        "worst": [_row(directory, table, int(i)) for i in order[::-1][:_SHOWN]],
    }


def _row(directory: StudyDirectory, table: xr.Dataset, i: int) -> dict[str, Any]:
    spec = directory.spec
    row: dict[str, Any] = {"geometry": i}
    row |= {v.name: float(table[v.name].values[i]) for v in spec.varied}
    for column in spec.columns:
        values = table[column.name].values[:, i]
        row[column.name] = {
            model: float(x) if np.isfinite(x) else None
            for model, x in zip(spec.models, values, strict=True)
        }
    return row


def status_as_json(directory: StudyDirectory) -> dict[str, Any]:
    """Return how far a study is."""
    finished = directory.finished()
    there = sum(directory.chunk_path(i).exists() for i in range(directory.n_chunks))
    return {
        "directory": str(directory.path),
        "title": directory.spec.title,
        "robot": directory.spec.robot,
        "stiffkit_version": directory.job.version,
        "geometries": directory.spec.n_geometries,
        "geometries_finished": int(sum(directory.numbers(i).size for i in finished)),
        "chunks": directory.n_chunks,
        "chunks_finished": len(finished),
        "chunks_damaged": there - len(finished),
        "table": str(directory.table) if directory.table.exists() else None,
    }


def show_status(directory: StudyDirectory) -> None:
    """Print how far a study is."""
    found = status_as_json(directory)
    click.echo(f"{found['title']} ({found['robot']}, stiffkit {found['stiffkit_version']})")
    click.echo(
        f"{found['geometries_finished']} of {found['geometries']} geometries,"
        f" {found['chunks_finished']} of {found['chunks']} chunks"
    )
    if found["chunks_damaged"]:
        click.echo(f"{found['chunks_damaged']} chunks are damaged, and will be computed again")
    if found["table"]:
        click.echo(f"table: {found['table']}")
    else:
        click.echo(f"go on with: stiffkit study resume {directory.path}")
