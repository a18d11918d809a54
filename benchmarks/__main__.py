"""All benchmarks: tables to read, and the same numbers as JSON. ``make bench``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from benchmarks import (
    gradients,
    identify,
    kernels,
    long_studies,
    machine,
    processes,
    stages,
    studio,
    studio_page,
    vibration,
)
from benchmarks.table import Cell, show
from stiffkit.compiled import thread_count

Row = Any
"""A dataclass of measured numbers."""


def main() -> None:
    """Run the sections that are asked for, print their tables and write the JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("sections", nargs="*", help=f"of: {', '.join(SECTIONS)}; all by default")
    parser.add_argument("--json", type=Path, default=Path("out", "bench.json"))
    arguments = parser.parse_args()
    unknown = set(arguments.sections) - set(SECTIONS)
    if unknown:
        parser.error(f"there is no section {', '.join(sorted(unknown))}")
    this = machine.measure()
    print(
        f"{this.system}, {this.processors} processors, Python {this.python}\n"
        f"multiply-add peak, one thread: {this.multiply_adds / 1e9:.1f} Gflop/s compiled,"
        f" {this.numpy_multiply_adds / 1e9:.1f} Gflop/s by NumPy on arrays of 1000\n"
        f"written into the rows of a large array: {this.row_writes / 1e9:.1f} GB/s\n"
    )
    results: dict[str, Any] = {"machine": asdict(this)}
    for name in arguments.sections or SECTIONS:
        rows = SECTIONS[name](this)
        results[name] = [{"kind": type(row).__name__} | asdict(row) for row in rows]
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(results, indent=1), encoding="utf-8")
    print(f"numbers in {arguments.json}")


def run_kernels(this: machine.Machine) -> list[Row]:
    """Kernels with joint coordinates given."""
    rows = [r for name in kernels.ROBOTS for r in kernels.measure(name, this.multiply_adds)]
    show(
        "Kernels, postures per second and thread (thousands); operations of one posture",
        (
            *("robot", "kernel", "compiled", "NumPy", "single", "compiled/NumPy"),
            *("compiled/single", "operations", "sines", "Gflop/s", "of peak", "compile, s"),
        ),
        [
            (
                *(r.robot, r.kernel, r.compiled / 1e3, r.numpy / 1e3, r.single / 1e3),
                *(r.compiled / r.numpy, r.compiled / r.single, r.arithmetic, r.functions),
                *(r.per_second / 1e9, f"{r.share_of_peak:.0%}", r.compile_seconds),
            )
            for r in rows
        ],
    )
    return rows


def run_stages(this: machine.Machine) -> list[Row]:
    """Whole static maps, by one thread and by all."""
    counts = sorted({1, thread_count()})
    rows = [stages.measure(name, n) for name in stages.POINTS for n in counts]
    show(
        "Static maps of both models, dataset in memory, seconds; CPU and kernels are of processors,"
        " written down: what the dataset's bytes take at the rate above",
        (
            *(
                "robot",
                "threads",
                "postures",
                "wall",
                "postures/s",
                "CPU",
                "kernels",
                "CPU/kernels",
            ),
            *("written down", "closure", "writing", "first", "dataset, GB", "peak, GB"),
        ),
        [
            (
                *(r.robot, r.threads, r.postures, r.wall, r.postures / r.wall, r.cpu),
                *(sum(r.kernels.values()), r.ratio, r.dataset_bytes / this.row_writes),
                *(r.closure, r.writing, r.first, r.dataset_bytes / 1e9, r.peak_bytes / 1e9),
            )
            for r in rows
        ],
    )
    names = sorted({name for r in rows for name in r.kernels})
    show(
        "Of these, seconds in each kernel",
        ("robot", "threads", *names),
        [(r.robot, r.threads, *(r.kernels.get(name, 0.0) for name in names)) for r in rows],
    )
    return rows


def run_frequencies(_this: machine.Machine) -> list[Row]:
    """Lowest natural frequencies."""
    with threadpool_limits(1):
        rows = [vibration.measure(name) for name in kernels.ROBOTS]
    show(
        "Lowest four natural frequencies, postures per second of a processor (NumPy, compiled: the"
        " fast model; kernel: without its eigenvalues; dense: full model; eigen: its eigenvalues)",
        (
            *("robot", "basis", "error", "NumPy", "compiled", "kernel", "steps", "compile, s"),
            *("dense", "eigen", "unknowns", "fast/dense"),
        ),
        [
            (
                *(r.robot, r.basis, r.error, r.interpreted, *map(_known, (r.compiled, r.kernel))),
                *(*map(_known, (r.steps, r.compile_seconds)), r.dense, r.eigen, r.unknowns),
                (r.compiled or r.interpreted) / r.dense,
            )
            for r in rows
        ],
    )
    return rows


def _known(number: float | None) -> Cell:
    return "-" if number is None else number


def run_identification(_this: machine.Machine) -> list[Row]:
    """A compliance from a large field."""
    r = identify.measure()
    show(
        "Compliance from a field, six load cases, with statistics, reading apart, one thread",
        ("nodes", "seconds", "GB/s", "plain sum, GB/s", "over plain sum", "peak, GB"),
        [
            (
                *(r.nodes, r.seconds, r.rate / 1e9, r.sum_rate / 1e9),
                *(r.seconds / r.sum_seconds, r.peak_bytes / 1e9),
            )
        ],
    )
    return [r]


def run_processes(_this: machine.Machine) -> list[Row]:
    """Whole commands, cold and warm."""
    rows = processes.measure()
    heads = [field.name.replace("_", " ") for field in fields(processes.ProcessTimes)]
    show("Whole processes, seconds", heads, [tuple(asdict(r).values()) for r in rows])
    return rows


def run_gradients(_this: machine.Machine) -> list[Row]:
    """Derivatives by all parameters, beside the values."""
    rows = [gradients.measure(name) for name in gradients.LOADS]
    show(
        "A mean deflection over the workspace and its derivatives by all parameters, refined model;"
        " seconds of a processor",
        (
            *("robot", "parameters", "postures", "value", "with derivatives", "ratio"),
            *("at the postures", "first time, s"),
        ),
        [
            (
                *(r.robot, r.parameters, r.postures, r.value, r.both, r.ratio),
                *(r.backwards, r.first),
            )
            for r in rows
        ],
    )
    return rows


SECTIONS: dict[str, Callable[[machine.Machine], list[Row]]] = {
    "kernels": run_kernels,
    "stages": run_stages,
    "frequencies": run_frequencies,
    "gradients": run_gradients,
    "reductions": long_studies.run_reductions,
    "cluster": long_studies.run_cluster,
    "scheduling": long_studies.run_scheduling,
    "identification": run_identification,
    "studio": studio.run_studio,
    "browser": studio_page.run_studio_page,
    "processes": run_processes,
}
"""By name, in the order in which they run."""


if __name__ == "__main__":
    main()
