"""Print the benchmark tables: ``make bench``."""

from __future__ import annotations

import sys
import sysconfig
import tempfile
import time
from pathlib import Path

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks import identify, vibration
from benchmarks.measure import process_seconds, seconds
from benchmarks.postures import ROBOTS, measure
from stiffkit.kinematics import Kinematics
from stiffkit.robot import load_robot
from stiffkit.study import Analysis, map_workspace

MILLION = 1_000_000


def main() -> None:
    """Print all tables."""
    print(f"multiply-add on arrays of 1000: {_multiply_adds() / 1e9:.2f} G/s, one thread, NumPy\n")
    print_rates()
    print_frequencies()
    print_identification()
    print_map()
    print_commands()


def _multiply_adds() -> float:
    a, b, c = (np.random.default_rng(0).random(1000) for _ in range(3))

    def work() -> None:
        for _ in range(2000):
            np.multiply(a, b, out=c)
            np.add(c, a, out=c)

    return 2000 * 1000 / seconds(work)


def print_rates() -> None:
    """Print postures per second and thread."""
    print("Postures per second, one thread, joint coordinates given (thousands)")
    heads = ("robot", "kernel", "compiled", "NumPy", "single", "compiled/NumPy", "compile, s")
    print("{:<15}{:<14}{:>10}{:>10}{:>10}{:>16}{:>12}".format(*heads))
    for name in ROBOTS:
        for r in measure(name):
            print(
                f"{r.robot:<15}{r.kernel:<14}{r.compiled / 1e3:>10.0f}{r.numpy / 1e3:>10.1f}"
                f"{r.single / 1e3:>10.2f}{r.compiled / r.numpy:>16.0f}{r.compile_seconds:>12.2f}"
            )
    print(flush=True)


def print_frequencies() -> None:
    """Print rates of the lowest natural frequencies."""
    print("Lowest four natural frequencies, postures per second, one thread")
    heads = ("robot", "basis", "fast", "dense", "eigen", "unknowns", "fast/dense", "error")
    print("{:<15}{:>7}{:>10}{:>10}{:>10}{:>10}{:>12}{:>10}".format(*heads))
    for name in ROBOTS:
        with threadpool_limits(1):
            r = vibration.measure(name)
        print(
            f"{r.robot:<15}{r.basis:>7}{r.fast:>10.0f}{r.dense:>10.1f}{r.eigen:>10.1f}{r.unknowns:>10}"
            f"{r.fast / r.dense:>12.0f}{r.error:>10.1e}"
        )
    print(
        "dense: full model, coordinates to frequencies; eigen: its eigenvalues alone\n", flush=True
    )


def print_identification() -> None:
    """Print what the identification of a compliance takes."""
    r = identify.measure()
    print(f"Compliance from {r.nodes} nodes, six load cases, with statistics, one thread")
    print(f"  seconds, reading apart            {r.seconds:8.2f}")
    print(f"  peak memory, field included       {r.peak_bytes / 1e9:8.2f} GB")
    print(f"  displacements                     {r.rate / 1e9:8.2f} GB/s")
    print(f"  the same, plain sum               {r.sum_rate / 1e9:8.2f} GB/s")
    print(f"  identification / plain sum        {r.seconds / r.sum_seconds:8.1f}\n", flush=True)


def print_map() -> None:
    """Print the parts of a map of a million postures."""
    robot = load_robot("biglide")
    start = time.perf_counter()
    analysis = Analysis(robot)
    kinematics: Kinematics = analysis.kinematics
    assembled = time.perf_counter() - start
    start = time.perf_counter()
    dataset = map_workspace(analysis, points=MILLION)
    mapped = time.perf_counter() - start
    n = dataset["status"].isel(model=0).size
    x, y = np.meshgrid(dataset["x"], dataset["y"], indexing="ij")
    start = time.perf_counter()
    kinematics.solve(np.stack([x.ravel(), y.ravel()]))
    closed = time.perf_counter() - start
    print(f"Biglide map of {n} postures, both models, loop closure included")
    print(f"  home posture                      {assembled:8.2f} s")
    print(f"  map, dataset in memory            {mapped:8.2f} s  ({n / mapped / 1e6:.2f} M/s)")
    print(f"  of which loop closure, warm       {closed:8.2f} s  ({n / closed / 1e6:.2f} M/s)")
    print(f"  postures with an answer           {(dataset['status'] == 0).mean().item():8.2%}\n")


def print_commands() -> None:
    """Print the times of whole processes."""
    scripts = Path(sysconfig.get_path("scripts"))
    stiffkit = str(scripts / "stiffkit")
    bare = process_seconds([sys.executable, "-c", "import numpy"])
    print("Whole processes, seconds (and times that of importing NumPy)")
    with tempfile.TemporaryDirectory() as folder:
        commands = [["--help"], *(["pose", name, "--json"] for name in ROBOTS)]
        commands.append(["map", "biglide", "-o", folder])
        for command in commands:
            taken = process_seconds([stiffkit, *command], 3)
            shown = " ".join(word for word in command if word not in ("-o", folder))
            print(f"  stiffkit {shown:<28}{taken:8.2f}  ({taken / bare:.1f})")


if __name__ == "__main__":
    main()
