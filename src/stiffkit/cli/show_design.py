"""Design studies as text for a terminal."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from stiffkit.cli.show import heading
from stiffkit.design import DATASET

if TYPE_CHECKING:
    import xarray as xr


def _names(designs: xr.Dataset, key: str, *values: str) -> list[str]:
    """Return the variables whose attribute ``key`` is one of some values."""
    return [str(n) for n, v in designs.data_vars.items() if v.attrs.get(key) in values]


def _parameters(designs: xr.Dataset) -> list[str]:
    return _names(designs, "kind", "continuous", "integer", "choice", "derived")


def _goals(designs: xr.Dataset) -> list[str]:
    return _names(designs, "role", "objective", "constraint")


def show_designs(designs: xr.Dataset) -> None:
    """Print the start and the best design of each model side by side, and what it took."""
    heading(str(designs.attrs["title"]))
    chosen = json.loads(designs.attrs["chosen"])
    models = [str(m) for m in designs["model"].values]
    columns = _columns(models, chosen)
    width = max(len(name) for name in [*_parameters(designs), *_goals(designs)]) + 2
    wide = max(16, *(len(title) + 2 for title, _, _ in columns))
    click.echo(" " * width + "".join(f"{title:>{wide}}" for title, _, _ in columns))
    for name in _parameters(designs):
        cells = "".join(f"{designs[name].values[i]:>{wide}.6g}" for _, i, _ in columns)
        click.echo(f"{name:<{width}}{cells}  {_unit(designs, name)}")
    for name in _goals(designs):
        values = [float(designs[name].values[models.index(m), i]) for _, i, m in columns]
        cells = "".join(f"{x:>{wide}.6g}" if np.isfinite(x) else f"{'-':>{wide}}" for x in values)
        wanted = _sense(designs[name].attrs)
        click.echo(f"{name:<{width}}{cells}  {_unit(designs, name):<8}{wanted}")
    for line in str(designs.attrs["message"]).splitlines():
        click.echo(click.style("infeasible: ", fg="red", bold=True) + line)
    for model in models:
        own = designs.sel(model=model)
        click.echo(f"{model}: {_how_many(own)}")
    for method, took in json.loads(designs.attrs["evaluations"]).items():
        click.echo(f"{method}: {took['geometries']:.0f} designs evaluated, {took['seconds']:.1f} s")


def _how_many(designs: xr.Dataset) -> str:
    """Return in words how many designs are feasible by a model, and how many are on the front."""
    feasible, total = designs["feasible"].values.astype(bool), designs.sizes["design"]
    if feasible[0] and feasible.sum() == 1 and total > 1:
        return f"of {total} designs only the start fulfils all constraints"
    on_front = int(designs["front"].sum())
    return f"{feasible.sum()} of {total} designs fulfil all constraints, {on_front} on the front"


def _columns(models: list[str], chosen: dict[str, int]) -> list[tuple[str, int, str]]:
    """Return title, design and model of each column."""
    if len(models) == 1:
        found = [("start", 0, models[0])]
        return [*found, ("best", chosen[models[0]], models[0])] if models[0] in chosen else found
    found = []
    for model in models:
        found.append((f"start, {model}", 0, model))
        if model in chosen:
            found.append((f"best, {model}", chosen[model], model))
    if len(chosen) == len(models) and "simplified" in chosen and "refined" in chosen:
        # What the refined model says of the design that the simplified one takes for the best.
        found.append(("same, refined", chosen["simplified"], "refined"))
    return found


def _unit(designs: xr.Dataset, name: str) -> str:
    units = str(designs[name].attrs["units"])
    return "" if units == "1" else units


def _sense(about: dict[str, Any]) -> str:
    if about["role"] == "objective":
        return "as large as can be" if about["sense"] == "max" else "as small as can be"
    bounds = np.unique(np.atleast_1d(about["bound_by_model"]))
    listed = " and ".join(f"{bound:.6g}" for bound in bounds if np.isfinite(bound))
    return f"{about['sense']} {listed}"


def designs_as_json(designs: xr.Dataset, directory: Path) -> dict[str, Any]:
    """Return what `show_designs` prints as plain data, SI."""
    chosen = json.loads(designs.attrs["chosen"])
    models = [str(m) for m in designs["model"].values]
    return {
        "directory": str(directory),
        "designs": str(directory / DATASET),
        "title": str(designs.attrs["title"]),
        "robot": str(designs.attrs["robot"]),
        "start": _row(designs, 0, models),
        "best": {model: _row(designs, number, models) for model, number in chosen.items()},
        "message": str(designs.attrs["message"]),
        "feasible": {m: int(designs["feasible"].sel(model=m).sum()) for m in models},
        "front": {m: int(designs["front"].sel(model=m).sum()) for m in models},
        "evaluations": json.loads(designs.attrs["evaluations"]),
    }


def _row(designs: xr.Dataset, number: int, models: list[str]) -> dict[str, Any]:
    row: dict[str, Any] = {"design": number, "origin": str(designs["origin"].values[number])}
    row |= {name: float(designs[name].values[number]) for name in _parameters(designs)}
    for name in _goals(designs):
        own = designs[name].isel(design=number).values.tolist()
        row[name] = {
            model: x if np.isfinite(x) else None for model, x in zip(models, own, strict=True)
        }
    return row
