"""One chunk of a study, in whatever process it is computed.

A worker gets this module's function by its name, and everything else as plain data.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.compiled import Backend
from stiffkit.compiled.threads import limited_threads
from stiffkit.errors import StiffkitError
from stiffkit.kinematics.numeric import one_thread
from stiffkit.study.sweep.anchors import Anchors
from stiffkit.study.sweep.derivatives import add_derivatives
from stiffkit.study.sweep.engine import Engine, Rows
from stiffkit.study.sweep.family import Family
from stiffkit.study.sweep.frequencies import Basis, LowestFrequencies
from stiffkit.study.sweep.group import Groups
from stiffkit.study.sweep.prepare import make_anchors
from stiffkit.study.sweep.spec import StudySpec
from stiffkit.study.sweep.train import train_basis

Array = NDArray[np.float64]
Reference = dict[str, Array]
"""What is computed once for a study, and begun from by every chunk."""

_MOST_ENGINES = 2
_WORTH_COMPILING = 1_000_000
"""Postures of a study at which frequencies are asked for, from which the fast model is compiled:
each process needs ten seconds to some minutes for it, and NumPy does not do badly on many."""


@dataclass(frozen=True)
class Job:
    """A study as a worker needs it."""

    key: str
    """Tells studies apart."""
    spec: dict[str, Any]
    """Of `StudySpec.plain`."""
    robot_hash: str
    backend: Backend
    version: str = __version__

    def plain(self) -> dict[str, Any]:
        """Return it as JSON can hold it."""
        return {
            "key": self.key,
            "spec": self.spec,
            "robot_hash": self.robot_hash,
            "backend": self.backend,
            "version": self.version,
        }


@dataclass(frozen=True, eq=False)
class Prepared:
    """What is known of a study once its robot file has been read."""

    robot_hash: str
    """Of the robot file with all that it takes."""
    swept: tuple[str, ...]
    """The tool coordinates of the workspace."""
    shape: tuple[int, ...]
    """Postures along each of them, or in all."""
    reference: Reference


def prepare(spec: StudySpec, backend: Backend) -> Prepared:
    """Return what all chunks of a study begin from.

    Raises FileError, AssemblyError or PoseError where the robot file's own geometry is at fault.
    """
    with one_thread(), limited_threads(1):
        groups = Groups(Family(spec), backend)
        family = groups.family
        anchors = make_anchors(groups)
        reference = anchors.arrays()
        if spec.frequency_postures:
            basis = train_basis(groups, anchors)
            reference |= {f"basis_{name}": array for name, array in basis.arrays().items()}
        return Prepared(family.robot.content_hash, family.swept, family.grid.shape, reference)


def as_given(reference: Reference) -> Reference:
    """Return the reference: the task of a cluster's worker that others have it from."""
    return reference


def compute_chunk(job: dict[str, Any], reference: Reference, values: Array) -> Rows:
    """Return the rows of geometries with these values (k, n) of the varied parameters.

    Raises StiffkitError where this process has another version of stiffkit or of the robot file.
    """
    # One chunk at a time: what an engine remembers is not made for several threads.
    with _lock, one_thread(), limited_threads(1):
        engine = _engine(Job(**job), reference)
        rows = engine.rows(values)
        if engine.spec.derivatives:
            add_derivatives(rows, engine, values)
        return rows


_lock = Lock()
_engines: OrderedDict[str, Engine] = OrderedDict()


def _engine(job: Job, reference: Reference) -> Engine:
    if job.key not in _engines:
        _engines[job.key] = _made(job, reference)
        while len(_engines) > _MOST_ENGINES:
            _engines.popitem(last=False)
    return _engines[job.key]


def _made(job: Job, reference: Reference) -> Engine:
    if job.version != __version__:
        raise StiffkitError(
            f"the study is of stiffkit {job.version}, and here is {__version__}",
            mend=f"install stiffkit {job.version} here, or begin the study anew",
        )
    family = Family(StudySpec.from_plain(job.spec))
    if family.robot.content_hash != job.robot_hash:
        raise StiffkitError(
            f"{family.file.path} has changed since the study began, or is another file here",
            mend="bring the file back, with all that it takes, or begin the study anew",
        )
    groups = Groups(family, job.backend)
    known = {name: array for name, array in reference.items() if not name.startswith("basis_")}
    frequencies = None
    if family.spec.frequency_postures:
        basis = {name: reference[f"basis_{name}"] for name in ("U", "trust")}
        frequencies = LowestFrequencies(Basis.of(basis), _worth(family.spec, job.backend))
    return Engine(groups, Anchors(**known), frequencies)


def _worth(spec: StudySpec, backend: Backend) -> Backend:
    """Return what computes frequencies: few of them are not worth compiling a large kernel."""
    few = spec.n_geometries * spec.frequency_postures < _WORTH_COMPILING
    return "numpy" if few else backend
