"""Running a study to its end, from wherever it stands."""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

from stiffkit.progress import Progress, no_progress
from stiffkit.study.sweep.directory import StudyDirectory
from stiffkit.study.sweep.executors import Executor, InProcess
from stiffkit.study.sweep.files import alone_in
from stiffkit.study.sweep.table import write_table

if TYPE_CHECKING:
    import xarray as xr


def run_study(
    directory: StudyDirectory, executor: Executor | None = None, progress: Progress | None = None
) -> xr.Dataset:
    """Compute the chunks of a study that are not finished, and return its table.

    Each chunk is on disk as soon as it is finished; whatever ends this leaves those that are.
    Raises OutputError where something cannot be written or another process is at work on it, and
    StiffkitError where workers cannot do it.
    """
    report = progress or no_progress
    with alone_in(directory.path):
        missing = sorted(set(range(directory.n_chunks)) - set(directory.finished()))
        done = directory.n_chunks - len(missing)
        report(_said(directory, done), done / directory.n_chunks)
        if missing:
            chunks = [(i, directory.values(i)) for i in missing]
            reference, job = directory.reference(), directory.job.plain()
            with closing((executor or InProcess()).run(job, reference, chunks)) as results:
                for number, rows in results:
                    directory.write_chunk(number, rows)
                    done += 1
                    report(_said(directory, done), done / directory.n_chunks)
        report("making the table", 1.0)
        return write_table(directory)


def _said(directory: StudyDirectory, done: int) -> str:
    geometries = min(done * directory.chunk_size, directory.spec.n_geometries)
    return f"{geometries} of {directory.spec.n_geometries} geometries"
