"""All programs at the same task, side by side. ``make bench-peers``."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

import numpy as np

from benchmarks.peers import case
from benchmarks.table import table

PEERS = ("opensees", "pynite", "exudyn", "pinocchio")
POSTURES = 50
MOST = {"compliance": 0.01, "frequencies": 0.02}
"""How far a program may be from ours: all cut beams into few elements, each in its own way."""


def main() -> None:
    """Run the programs one after another, print a table and write the JSON."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.peers", description=__doc__)
    parser.add_argument("--python", required=True, help="the interpreter that has the programs")
    parser.add_argument("--json", type=Path, default=Path("out", "bench-peers.json"))
    arguments = parser.parse_args()
    answers = [_answer(sys.executable, "ours"), *(_answer(arguments.python, p) for p in PEERS)]
    ours = answers[0]
    heads = ("program", "version", "static, first s", "per second", "ours/theirs", "compliance")
    more = ("modes, first s", "per second", "ours/theirs", "frequencies")
    print(
        table(
            (*heads, *more),
            [
                (
                    *(a.program, a.version, a.first_static, a.static_rate),
                    ours.static_rate / a.static_rate,
                    difference(a.compliance, ours.compliance),
                    *(a.first_modes, a.modes_rate, ours.modes_rate / a.modes_rate),
                    difference(a.frequencies, ours.frequencies),
                )
                for a in answers
            ],
        )
    )
    print("times are of a processor, one thread")
    print("compliance, frequencies: largest difference from ours, over the largest of a posture")
    for a in answers:
        print(f"{a.program}: {a.way}")
    arguments.json.parent.mkdir(parents=True, exist_ok=True)
    results = [asdict(a) for a in answers]
    arguments.json.write_text(json.dumps(results, indent=1), encoding="utf-8")
    print(f"numbers in {arguments.json}")
    if apart := disagreeing(answers):
        sys.exit(f"not the same task any more: {', '.join(apart)} differ from ours")


def disagreeing(answers: Sequence[case.Answer]) -> list[str]:
    """Return what is further from the first answer than it may: "the frequencies of PyNite"."""
    ours, *others = answers
    return [
        f"the {what} of {a.program}"
        for a in others
        for what, most in MOST.items()
        if not difference(getattr(a, what), getattr(ours, what)) <= most
    ]


def _answer(python: str, program: str) -> case.Answer:
    command = [python, "-m", "benchmarks.peers.one", program, str(POSTURES)]
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    environment["STIFFKIT_THREADS"] = "1"
    done = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, env=environment)
    return case.Answer(**json.loads(done.stdout.splitlines()[-1]))


def difference(theirs: list[list[float]] | list[case.Matrix], ours: object) -> float:
    """Return the largest difference of N postures, each over the largest number of its own."""
    a, b = np.array(theirs, dtype=float), np.array(ours, dtype=float)
    axes = tuple(range(1, a.ndim))
    return float((np.abs(a - b).max(axis=axes) / np.abs(b).max(axis=axes)).max())


if __name__ == "__main__":
    main()
