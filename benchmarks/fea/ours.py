"""Stiffkit's adaptive solution of a part, in a process of its own to tell its memory."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import asdict, dataclass

import numpy as np
from threadpoolctl import threadpool_limits

from benchmarks.fea.parts import CASES, STEEL
from benchmarks.measure import Cost, cost, median_cost, peak_bytes
from stiffkit.fea import SolveSettings, reduce_part
from stiffkit.fea.adapt import Adapted, AdaptSettings, adapt
from stiffkit.spatial.rotation import Array


@dataclass(frozen=True, eq=False)
class Loop:
    """One adaptive solution to an estimated error."""

    unknowns: int
    """Of the last solution."""
    estimate: float
    """Relative error of the compliance that is estimated, over all wrenches."""
    total: Cost
    """From the part's geometry on: all meshes and all solutions."""
    last: Cost
    """Of assembly and solution on the last mesh alone."""
    peak_bytes: int
    """Of the process; the mesher has one of its own, and is smaller."""
    compliance: Array
    """(6, 6)."""


def solve(name: str, tolerance: float, threads: int | None) -> Loop:
    """Return what a part takes, in a process of its own; threads as for `SolveSettings`."""
    code = "import sys; from benchmarks.fea.ours import print_loop; print_loop(*sys.argv[1:])"
    done = subprocess.run(
        [sys.executable, "-c", code, name, str(tolerance), str(threads or 0)],
        check=True,
        capture_output=True,
        text=True,
        env=os.environ | {"OMP_NUM_THREADS": str(threads or 1)},
    )
    plain = json.loads(done.stdout)
    return Loop(
        total=Cost(**plain.pop("total")),
        last=Cost(**plain.pop("last")),
        compliance=np.array(plain.pop("compliance")),
        **plain,
    )


def print_loop(name: str, tolerance: str, threads: str) -> None:
    """Measure in this process, and print the result as JSON; 0 threads are those chosen."""
    with threadpool_limits(1):
        print(json.dumps(asdict(_measure(name, float(tolerance), int(threads) or None))))


def _measure(name: str, tolerance: float, threads: int | None) -> Loop:
    case = CASES[name]
    part = case.build()
    ports = case.ports(part)
    settings = AdaptSettings(tolerance=tolerance, solve=SolveSettings(threads=threads))
    found: list[Adapted] = []
    total = cost(lambda: found.append(adapt(part, ports, [STEEL], settings)))
    peak = peak_bytes()
    adapted = found[0]
    body = adapted.model.solver.body
    body.release()
    last = median_cost(lambda: reduce_part(adapted.mesh, ports, [STEEL], body.settings), 1)
    k = adapted.model.compliance
    return Loop(adapted.model.n_unknowns, adapted.estimate, total, last, peak, k.tolist())
