"""Everything about a robot's workspace in one directory: dataset, figures and report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stiffkit.plots import write_figures
from stiffkit.progress import Progress, no_progress
from stiffkit.report.page import write_report
from stiffkit.report.words import status_in_words
from stiffkit.study import Analysis, map_workspace, summarise, whole_directory, write_dataset

if TYPE_CHECKING:
    from stiffkit.study import Summary


@dataclass(frozen=True, eq=False)
class WrittenMap:
    """What was written, and what there is to say about it."""

    sentences: Sequence[str]
    """How much of the workspace has an answer."""
    summary: Summary
    n_figures: int


def write_map(
    analysis: Analysis,
    target: Path,
    *,
    points: int | None = None,
    threads: int | None = None,
    report: bool = True,
    progress: Progress = no_progress,
) -> WrittenMap:
    """Write map.nc (or map.zarr) of both models into ``target``, with figures and ``report``.

    ``points`` is about how many postures, by default what the robot file asks for. Without
    ``report`` there are no figures/ and no report.html. All is there in the end, or nothing.
    Raises PoseError for a workspace that cannot be swept, OutputError where nothing can be written.
    """
    with whole_directory(target) as work:
        summary = summarise(analysis)
        dataset = map_workspace(analysis, points=points, threads=threads, progress=progress)
        progress("writing the dataset", 1.0)
        write_dataset(dataset, work)
        figures: Sequence[Path] = ()
        if report:
            progress("drawing figures", 1.0)
            figures = write_figures(dataset, work / "figures")
            progress("writing the report", 1.0)
            write_report(dataset, summary.facts, work / "report.html", figures)
    return WrittenMap(status_in_words(dataset), summary, len(figures))
