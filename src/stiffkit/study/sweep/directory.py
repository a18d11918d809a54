"""A study on disk: what it is, what every chunk begins from, and the chunks that are finished."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from stiffkit import __version__
from stiffkit.compiled import Backend, decided, default_backend
from stiffkit.errors import OutputError
from stiffkit.study.sweep.engine import Rows
from stiffkit.study.sweep.files import digest, read_arrays, write_arrays, write_whole
from stiffkit.study.sweep.sampling import parameter_values
from stiffkit.study.sweep.spec import StudySpec
from stiffkit.study.sweep.work import Job, Prepared, Reference, prepare

Array = NDArray[np.float64]

FORMAT = 1
"""Of the directory; other versions of stiffkit may have another."""

_BEGINNINGS = {"chunks", "reference.npz", ".lock"}
"""What is there of a study that was interrupted before it had begun."""
_COST_OF_CHUNK = 1200
"""Postures that are computed in the time that one process needs to give out a chunk and to take its
rows back: 5 ms on a cluster (``python -m benchmarks cluster``)."""
_CHUNKS_OF_WORKER = 4
"""Chunks for each worker, so that all end at about the same time."""
_FEWEST_POSTURES, _MOST_POSTURES = 1 << 15, 1 << 20
"""Of a chunk: 0.1 s of work, beside which what a chunk costs its worker is little, and some seconds
of work, which are soon done again where they are lost."""
_FREQUENCY = 100
"""Postures that are computed in the time of one frequency."""


@dataclass(frozen=True, eq=False)
class StudyDirectory:
    """A directory with ``study.json``, ``reference.npz`` and ``chunks``."""

    path: Path
    spec: StudySpec
    job: Job
    chunk_size: int
    """Geometries of a chunk; the last one may have fewer."""
    created: str
    swept: tuple[str, ...]
    """The tool coordinates of the workspace."""
    shape: tuple[int, ...]
    """Postures along each of them, or in all."""

    @property
    def n_chunks(self) -> int:
        """Number of chunks."""
        return -(-self.spec.n_geometries // self.chunk_size)

    @property
    def table(self) -> Path:
        """Where the table goes."""
        return self.path / "table.nc"

    def numbers(self, chunk: int) -> NDArray[np.intp]:
        """Return the numbers of the geometries of a chunk."""
        start = chunk * self.chunk_size
        return np.arange(start, min(start + self.chunk_size, self.spec.n_geometries))

    def values(self, chunk: int) -> Array:
        """Return the values (k, n) of the varied parameters of a chunk's geometries."""
        return parameter_values(self.spec, self.numbers(chunk))

    def reference(self) -> Reference:
        """Return what every chunk begins from. Raises OutputError where it is damaged."""
        arrays = read_arrays(self.path / "reference.npz")
        if arrays is None:
            raise OutputError(
                f"{self.path / 'reference.npz'} is missing or damaged, and no chunk can do"
                " without it",
                mend="begin the study anew in another directory",
            )
        return {name: np.asarray(array, dtype=float) for name, array in arrays.items()}

    def chunk_path(self, chunk: int) -> Path:
        """Return where the rows of a chunk are."""
        return self.path / "chunks" / f"{chunk:06d}.npz"

    def write_chunk(self, chunk: int, rows: Rows) -> None:
        """Keep the rows of a chunk. Raises OutputError where that is not possible."""
        write_arrays(self.chunk_path(chunk), {**rows, "study": np.array(self.job.key)})

    def read_chunk(self, chunk: int) -> Rows | None:
        """Return the rows of a chunk; None where there are none, or none that can be used."""
        rows = read_arrays(self.chunk_path(chunk))
        if rows is None or str(rows.pop("study", "")) != self.job.key:
            return None
        return rows

    def finished(self) -> list[int]:
        """Return the chunks that are there and whole."""
        return [i for i in range(self.n_chunks) if self.read_chunk(i) is not None]


def chunk_size_of(spec: StudySpec) -> int:
    """Return how many geometries a chunk has if nobody says.

    The process that gives out chunks keeps no more workers busy than chunks that it handles while
    one is computed, and these many workers shall have `_CHUNKS_OF_WORKER` chunks each. So chunks
    grow with the square root of the study, as does the number of workers that it is good for.
    """
    geometry = spec.postures + _FREQUENCY * spec.frequency_postures
    balanced = math.sqrt(geometry * spec.n_geometries * _COST_OF_CHUNK / _CHUNKS_OF_WORKER)
    return max(1, int(np.clip(balanced, _FEWEST_POSTURES, _MOST_POSTURES)) // geometry)


def create_study(
    path: Path, spec: StudySpec, *, chunk_size: int | None = None, backend: Backend | None = None
) -> StudyDirectory:
    """Return the directory of a study, new, or begun before with the same study.

    Raises OutputError where it cannot be written or holds something else, and whatever is wrong
    with the robot file's own geometry.
    """
    if (path / "study.json").exists():
        return _begun_before(path, spec)
    if path.exists() and not (path.is_dir() and {p.name for p in path.iterdir()} <= _BEGINNINGS):
        raise OutputError(
            f"{path} is there already and holds no study", mend="choose another directory with -o"
        )
    chosen = decided(backend or default_backend())
    prepared = prepare(spec, chosen)
    key = _key(spec, prepared, chosen)
    made = {
        "format": FORMAT,
        "job": Job(key, spec.plain(), prepared.robot_hash, chosen).plain(),
        "swept": prepared.swept,
        "shape": prepared.shape,
        "geometries": spec.n_geometries,
        "chunk_size": chunk_size or chunk_size_of(spec),
        "created": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    try:
        (path / "chunks").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(
            f"{path} cannot be written: {error.strerror or error}",
            mend="choose another directory with -o",
        ) from error
    write_arrays(path / "reference.npz", prepared.reference)
    # Last of all: what has a study.json can be resumed.
    write_whole(path / "study.json", (json.dumps(made, indent=1) + "\n").encode())
    return open_study(path)


def open_study(path: Path) -> StudyDirectory:
    """Return the study in a directory. Raises OutputError where there is none."""
    file = path / "study.json"
    try:
        made: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if made["format"] != FORMAT:
            raise OutputError(
                f"{file} has format {made['format']}, and this stiffkit knows format {FORMAT}",
                mend="use the version of stiffkit that began the study",
            )
        spec = StudySpec.from_plain(made["job"]["spec"])
        return StudyDirectory(
            path,
            spec,
            Job(**made["job"]),
            int(made["chunk_size"]),
            str(made["created"]),
            tuple(made["swept"]),
            tuple(made["shape"]),
        )
    except FileNotFoundError:
        raise OutputError(
            f"there is no study in {path}",
            mend="begin one with 'stiffkit study run STUDY.yaml -o DIR'",
        ) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise OutputError(
            f"{file} is damaged: {error}", mend="begin the study anew in another directory"
        ) from None


def _begun_before(path: Path, spec: StudySpec) -> StudyDirectory:
    found = open_study(path)
    if found.spec != spec:
        raise OutputError(
            f"{path} holds another study, '{found.spec.title}'",
            mend="choose another directory with -o, or go on with that one by"
            f" 'stiffkit study resume {path}'",
        )
    return found


def _key(spec: StudySpec, prepared: Prepared, backend: Backend) -> str:
    """Return what tells a study from others: workers keep what they made for one by it.

    What chunks begin from belongs to it. Its last digits may differ where a study is begun anew.
    """
    parts = [json.dumps(spec.plain(), sort_keys=True), prepared.robot_hash, backend, __version__]
    parts.append(digest(prepared.reference).hex())
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()
