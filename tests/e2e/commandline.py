"""Running the installed command in a directory of the test's own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

STIFFKIT = str(Path(sys.executable).with_name("stiffkit"))

ENDS_WITHIN = 60.0
"""Seconds; a command that takes longer hangs."""

SMALL_ROBOT = """\
robot: Two arms
parameters: {arm: 400 mm}
links:
  upper: {beam: {length: = arm, section: {tube: [60 mm, 4 mm]}, material: aluminium}}
  fore: {beam: {length: 300 mm, section: {tube: [50 mm, 3 mm]}, material: aluminium}}
joints:
  shoulder: {revolute: z, from: base, to: upper.base, drive: 1e4 N m/rad}
  elbow: {revolute: z, from: upper.tip, to: fore.base, drive: 5e3 N m/rad}
tool: {at: fore.tip}
home: {shoulder: 30 deg, elbow: 60 deg}
workspace: {x: [200 mm, 400 mm]}
"""
"""A serial robot whose maps take little time: one coordinate and no load case."""


def run(
    *arguments: str,
    cwd: Path,
    timeout: float = ENDS_WITHIN,
    limit: str = "",
    program: str = STIFFKIT,
) -> subprocess.CompletedProcess[str]:
    """Run ``stiffkit`` with arguments to its end.

    ``limit`` is an option of bash's ulimit with its value: ``-d KIB`` bounds the memory, ``-f KIB``
    the size of files. ``program`` is the command of another installation.
    """
    command = [program, *arguments]
    if limit:
        # Libraries of linear algebra reserve memory for each of their threads.
        bounded = f'ulimit {limit} && OPENBLAS_NUM_THREADS=1 exec "$0" "$@"'
        command = ["bash", "-c", bounded, *command]
    return subprocess.run(
        command,
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=timeout,
        check=False,
    )


def output_of(*arguments: str, cwd: Path, program: str = STIFFKIT) -> str:
    """Run ``stiffkit``, which must succeed without a word on standard error; return its output."""
    ended = run(*arguments, cwd=cwd, program=program)
    assert ended.returncode == 0, ended.stderr
    assert ended.stderr == ""
    return ended.stdout


def refusal_of(*arguments: str, cwd: Path, timeout: float = ENDS_WITHIN, limit: str = "") -> str:
    """Run ``stiffkit``, which must refuse with one message; return that on one line."""
    ended = run(*arguments, cwd=cwd, timeout=timeout, limit=limit)
    assert ended.returncode == 2, ended.stdout + ended.stderr
    assert ended.stdout == ""
    assert "Traceback" not in ended.stderr
    assert ended.stderr.lower().count("error: ") == 1
    return " ".join(ended.stderr.split())
