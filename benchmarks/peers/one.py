"""One program in the environment that it is installed in: its answer as JSON."""

from __future__ import annotations

import argparse
import importlib
import json
from dataclasses import asdict


def main() -> None:
    """Print the answer of a program."""
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("postures", type=int)
    arguments = parser.parse_args()
    program = importlib.import_module(f"benchmarks.peers.{arguments.program}")
    print("\n" + json.dumps(asdict(program.run(arguments.postures))))


if __name__ == "__main__":
    main()
