"""Print CalculiX beside Stiffkit: ``make bench-fea``."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.fea import ours
from benchmarks.fea.compare import Accuracy, Mesh, Same, convergence, same_error, same_mesh
from benchmarks.fea.convergence import Errors, errors
from benchmarks.fea.ours import Loop
from benchmarks.fea.parts import CASES, REFERENCES, Case
from stiffkit.fea import Part

TOLERANCE = 1e-3


def main() -> None:
    """Print all tables, and write them as JSON where that is asked for."""
    options = argparse.ArgumentParser(prog="python -m benchmarks.fea", description=__doc__)
    options.add_argument("--part", choices=[*CASES], action="append", help="only this part")
    options.add_argument("--json", type=Path, help="write all figures to this file")
    given = options.parse_args()
    cases = [CASES[name] for name in given.part or CASES]
    with threadpool_limits(1):
        found = measure([(case, case.build()) for case in cases])
    if given.json:
        given.json.parent.mkdir(parents=True, exist_ok=True)
        given.json.write_text(json.dumps(found, indent=1, default=_plain) + "\n", encoding="utf-8")


def measure(parts: list[tuple[Case, Part]]) -> dict[str, Any]:
    """Measure and print everything; return it as plain values."""
    same = print_same_mesh(parts)
    best = {s.part: s.best for s in same if s.tip == "average"}
    accuracy = print_same_error(parts, best)
    alone = print_alone([case for case, _ in parts])
    return {
        "same mesh": [asdict(s) for s in same],
        "same error": [asdict(a) for a in accuracy],
        "alone": {name: asdict(loop) for name, loop in alone.items()},
    }


def print_same_mesh(parts: list[tuple[Case, Part]]) -> list[Same]:
    """Print what both take on identical meshes."""
    print("The same mesh of quadratic tetrahedra (C3D10, order 2), one core each")
    print("Seconds of processor (and that pass) for assembly and solution, reading apart")
    heads = (
        "part",
        "tip",
        "unknowns",
        "CalculiX's loads",
        "CalculiX",
        "Stiffkit",
        "ratio",
        "apart",
    )
    print("{:<12}{:<9}{:>9}  {:<17}{:>16}{:>16}{:>7}{:>9}".format(*heads))
    out = []
    for case, part in parts:
        for tip in ("average", "rigid"):
            s = same_mesh(case, part, tip)
            for way in s.processes:
                apart = f"{s.difference[way]:.0e}" if way in s.difference else ""
                print(
                    f"{s.part:<12}{s.tip:<9}{s.unknowns:>9}  {way:<17}{_cost(s.theirs(way)):>16}"
                    f"{_cost(s.ours):>16}{s.ratio(way):>7.1f}{apart:>9}",
                    flush=True,
                )
            out.append(s)
    print("Stiffkit always solves for all six loads.")
    print("one step: the first load alone; six steps: *STATIC, each step factorises anew;")
    print("Green: *GREEN, which factorises once; apart: the two compliances, all wrenches\n")
    return out


def print_same_error(parts: list[tuple[Case, Part]], best: dict[str, Any]) -> list[Accuracy]:
    """Print what both take to reach an error."""
    print("CalculiX on finer and finer meshes, its best way to give six loads, one core")
    heads = ("part", "unknowns", "processor, s", "error, wrenches", "error, elements")
    print("{:<12}{:>9}{:>14}{:>17}{:>17}".format(*heads))
    meshes: dict[str, list[Mesh]] = {}
    for case, part in parts:
        meshes[case.name] = convergence(case, part, best[case.name])
        for m in meshes[case.name]:
            print(
                f"{case.name:<12}{m.unknowns:>9}{m.cost.cpu:>14.1f}{m.errors.wrenches:>17.2%}"
                f"{m.errors.elements:>17.3%}",
                flush=True,
            )
    print("\nThe same error, one core: seconds of processor, and CalculiX's over Stiffkit's")
    out = []
    for case, _ in parts:
        for tolerance in case.tolerances:
            a = same_error(case, meshes[case.name], best[case.name], tolerance)
            _print_accuracy(a)
            out.append(a)
    print("wrenches: largest error over all wrenches; elements: largest of the matrix's elements")
    print(f"Errors are against {REFERENCES.name}, of an estimated error of", end=" ")
    stored = json.loads(REFERENCES.read_text("utf-8"))
    print(", ".join(f"{stored[c.name]['estimated error']:.1e} ({c.name})" for c, _ in parts), "\n")
    return out


def _print_accuracy(a: Accuracy) -> None:
    total, last = a.ours.total.cpu, a.ours.last.cpu
    print(f"  {a.part} to {a.tolerance:.1%}")
    print(f"    Stiffkit, all meshes and solutions {total:10.2f}   error {_errors(a.ours_errors)}")
    print(f"    Stiffkit, last solution alone      {last:10.2f}   {a.ours.unknowns} unknowns")
    for name, reached in (("wrenches", a.by_wrenches), ("elements", a.by_elements)):
        guess = ", extrapolated" if reached.extrapolated else ""
        print(
            f"    CalculiX, {name:<25}{reached.cpu:>10.3g}   "
            f"{reached.unknowns:.2g} unknowns{guess}; "
            f"{reached.cpu / total:.3g} and {reached.cpu / last:.3g} times as long",
            flush=True,
        )


def print_alone(cases: list[Case]) -> dict[str, Loop]:
    """Print what Stiffkit takes by itself."""
    print(f"Stiffkit to an estimated {TOLERANCE:.1%}, as many threads as cores are idle")
    out = {}
    for case in cases:
        loop = out[case.name] = ours.solve(case.name, TOLERANCE, None)
        print(f"  {case.name}: {loop.unknowns} unknowns")
        print(f"    all meshes and solutions, s     {_cost(loop.total):>16}")
        print(f"    last assembly and solution, s   {_cost(loop.last):>16}")
        print(f"    peak memory                     {loop.peak_bytes / 1e9:8.2f} GB")
        print(f"    estimated error                 {loop.estimate:8.3%}")
        real = errors(loop.compliance, case.reference())
        print(f"    real error                      {_errors(real)}", flush=True)
    return out


def _cost(cost: Any) -> str:
    return f"{cost.cpu:.2f} ({cost.wall:.2f})"


def _errors(found: Errors) -> str:
    return f"{found.wrenches:.3%} (wrenches), {found.elements:.4%} (elements)"


def _plain(value: Any) -> Any:
    """Return arrays as lists."""
    if isinstance(value, np.ndarray):
        return value.tolist()
    raise TypeError(f"{type(value)} is not plain")


if __name__ == "__main__":
    main()
