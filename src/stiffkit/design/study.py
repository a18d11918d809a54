"""A design study from its file to its designs, in a directory where it can be interrupted."""

from __future__ import annotations

import hashlib
import json
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.compiled import Backend, decided, default_backend
from stiffkit.design.clash import explain
from stiffkit.design.dataset import About, Designs, make_dataset
from stiffkit.design.descent import Descent
from stiffkit.design.evaluation import Evaluation
from stiffkit.design.evolution import check_installed, run_evolution
from stiffkit.design.globally import run_global
from stiffkit.design.grid import run_grid
from stiffkit.design.journal import Journal
from stiffkit.design.judge import Judge
from stiffkit.design.multistart import run_gradient
from stiffkit.design.record import Record
from stiffkit.design.slopes import Slopes
from stiffkit.design.space import Space
from stiffkit.design.spec import DesignSpec
from stiffkit.errors import OutputError
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import load_robot
from stiffkit.study.sweep.files import alone_in, write_whole

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

DATASET = "designs.nc"
"""The name of the dataset in the directory of a study."""

_STUDY, _STEPS = "design.json", "steps"
_BEGINNINGS = {_STEPS, ".lock"}


def run_design(
    spec: DesignSpec,
    directory: Path | None = None,
    *,
    backend: Backend | None = None,
    progress: Progress = no_progress,
) -> xr.Dataset:
    """Run a design study, or go on with it, and return its designs.

    With a directory, what is finished is kept there step by step, and the designs are written as
    ``designs.nc``. Raises OutputError where that holds something else or cannot be written, and
    whatever is wrong with the robot file's own design.
    """
    if spec.methods.evolution is not None:
        check_installed()  # before what takes long
    progress("preparing", 0.0)
    chosen = decided(backend or default_backend())
    if directory is None:
        created = datetime.now(UTC).isoformat(timespec="seconds")
        return _Run(Evaluation(spec, chosen), Journal(None, ""), progress).dataset(created)
    key = _key(spec, chosen)
    created = _begin(directory, spec, key)
    with alone_in(directory):
        finished = _finished(directory)
        if finished is not None:
            return finished
        journal = Journal(directory / _STEPS, key)
        found = _Run(Evaluation(spec, chosen), journal, progress).dataset(created)
        # In memory first: where a disk is full, HDF5 brings the whole process down.
        write_whole(directory / DATASET, bytes(found.to_netcdf(engine="h5netcdf")))
    return found


def _finished(directory: Path) -> xr.Dataset | None:
    """Return the designs that are there already; None where there are none, or damaged ones."""
    import xarray as xr  # slow to import

    try:
        return xr.load_dataset(directory / DATASET, engine="h5netcdf")
    except (OSError, ValueError, KeyError):
        return None


def _key(spec: DesignSpec, backend: Backend) -> str:
    robot = load_robot(spec.robot).content_hash
    parts = [json.dumps(spec.plain(), sort_keys=True), robot, backend, __version__]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _begin(path: Path, spec: DesignSpec, key: str) -> str:
    """Make the directory of a study, or find it there; return when it was begun."""
    file = path / _STUDY
    if file.exists():
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
            title, begun_with, created = found["title"], found["key"], str(found["created"])
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise OutputError(
                f"{file} is damaged: {error}", mend="begin the study anew in another directory"
            ) from None
        if begun_with != key:
            same = title == spec.title
            raise OutputError(
                f"{path} holds the study '{title}'"
                + (", begun with another file, robot or stiffkit" if same else ""),
                mend="choose another directory with -o",
            )
        return created
    if path.exists() and not (path.is_dir() and {p.name for p in path.iterdir()} <= _BEGINNINGS):
        raise OutputError(
            f"{path} is there already and holds no design study",
            mend="choose another directory with -o",
        )
    try:
        (path / _STEPS).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written: {error.strerror or error}",
            mend="choose another directory with -o",
        ) from error
    made = {
        "title": spec.title,
        "key": key,
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
        "stiffkit_version": __version__,
        "study": spec.plain(),
    }
    write_whole(file, (json.dumps(made, indent=1) + "\n").encode())
    return str(made["created"])


class _Run:
    """One run through all methods of a study."""

    def __init__(self, evaluation: Evaluation, journal: Journal, progress: Progress) -> None:
        self.evaluation = evaluation
        self.spec = evaluation.spec
        self.space = Space(self.spec.variables)
        self.journal = journal
        self.progress = progress
        self.own = evaluation.start()
        start = evaluation.at(self.own[:, None])
        self.judge = Judge(self.spec, start[:, :, 0])
        self.start = start
        self.records: dict[str, Record] = {}

    def record(self, name: str) -> Record:
        if name not in self.records:
            self.records[name] = Record(name, self.evaluation, self.space, self.journal)
        return self.records[name]

    def dataset(self, created: str) -> xr.Dataset:
        methods, judge, seed = self.spec.methods, self.judge, self.spec.methods.seed
        start = self.space.points(self.own[:, None])[:, 0]
        if methods.grid is not None:
            run_grid(methods.grid, self.record("grid"), self.progress)
        if methods.gradient is not None:
            record = self.record("gradient")
            run_gradient(methods.gradient, record, judge, start, seed, self.progress)
        for model in range(len(self.spec.models)):
            if methods.evolution is not None:
                run_evolution(
                    methods.evolution,
                    self.record("evolution"),
                    judge,
                    self.found(start),
                    model,
                    seed,
                    self.progress,
                )
            if methods.global_ is not None:
                record = self.record("global")
                run_global(methods.global_, record, judge, model, seed, self.progress)
        message = self.message(start)
        about = About(
            self.evaluation.family.robot.content_hash, created, self.evaluations(), message
        )
        return make_dataset(self.designs(), judge, about)

    def found(self, start: Array) -> tuple[Array, Array]:
        """Return the points (k, n) found so far, the start's among them, and their measures."""
        records = list(self.records.values())
        points = [start[:, None], *(record.points for record in records)]
        nearest = self.evaluation.at(self.space.parameters(start[:, None]))
        measures = [nearest, *(record.measures for record in records)]
        return np.concatenate(points, axis=1), np.concatenate(measures, axis=2)

    def message(self, start: Array) -> str:
        """Return what clashes by each model that has no feasible design."""
        points, measures = self.found(start)
        feasible = self.judge.feasible(np.concatenate([measures, self.start], axis=2))
        sentences = []
        slopes = Slopes(self.evaluation, self.space)
        for model, any_feasible in enumerate(map(np.any, feasible)):
            if not any_feasible:
                self.progress("looking for what clashes", model / len(feasible))
                descent = Descent(slopes, self.judge, model)
                record = self.record("gradient")
                sentences.append(explain(record, self.judge, descent, (points, measures)))
        return "\n".join(sentences)

    def evaluations(self) -> dict[str, dict[str, float]]:
        return {
            name: {"geometries": record.count, "seconds": round(record.seconds, 3)}
            for name, record in self.records.items()
        }

    def designs(self) -> Designs:
        """Return all designs, each once."""
        parameters, measures, origin = [self.own[:, None]], [self.start], ["start"]
        seen = {self.own.tobytes()}
        for name, record in self.records.items():
            own = self.space.parameters(record.points)
            new = []
            for i, column in enumerate(own.T):
                if column.tobytes() not in seen:
                    seen.add(column.tobytes())
                    new.append(i)
            parameters.append(own[:, new])
            measures.append(record.measures[:, :, new])
            origin += [name] * len(new)
        values = np.concatenate(parameters, axis=1)
        return Designs(
            values,
            self.derived(values),
            self.options(values),
            np.concatenate(measures, axis=2),
            tuple(origin),
        )

    def derived(self, values: Array) -> dict[str, tuple[str, Array]]:
        """Return the parameters that follow from others, with their units."""
        names = [name for name, _ in self.spec.derived]
        if not names:
            return {}
        rows = [self.evaluation.family.parameters(own) for own in values.T]
        own = self.evaluation.family.robot.parameters
        return {name: (own[name].unit, np.array([row[name] for row in rows])) for name in names}

    def options(self, values: Array) -> dict[str, Array]:
        """Return the number of each named option, -1 where none has these values."""
        found: dict[str, Array] = {}
        for variable, row in zip(self.spec.variables, self.space.rows, strict=True):
            if variable.options:
                own = values[row : row + len(variable.parameters)]
                same = (np.array(variable.values)[:, :, None] == own[:, None]).all(axis=0)
                found[variable.name] = np.where(same.any(axis=0), same.argmax(axis=0), -1)
        return found
