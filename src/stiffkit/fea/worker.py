"""The child process that touches the CAD kernel and the mesher: ``worker FOLDER``.

It reads ``job.json`` in its folder, does one task, and writes ``answer.json`` last, so that an
answer that is there is whole. Only `stiffkit.fea.child` starts it.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from stiffkit.errors import StiffkitError
from stiffkit.fea.kernel import build_part, build_registered, export_registered, read_part
from stiffkit.fea.mesher import mesh_shape

TASKS = {
    "read": read_part,
    "build": build_part,
    "parametric": build_registered,
    "export": export_registered,
    "mesh": mesh_shape,
}


def main(folder: Path) -> int:
    """Do the job in ``folder`` and return the exit status."""
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    _limit_memory(job["memory"])
    _write_answer(folder, _answer(folder, job))
    return 0


def _answer(folder: Path, job: dict[str, Any]) -> dict[str, Any]:
    """Return the task's answer, or the error that it met."""
    try:
        return TASKS[job["task"]](folder, job)
    except StiffkitError as error:
        return {"error": error.what, "mend": error.mend}
    except MemoryError:
        return {
            "error": f"it needs more than {job['memory'] / 1e9:.1f} GB of memory",
            "mend": "ask for a larger mesh size, or suppress small features",
        }
    except Exception as error:  # the kernel's binding raises exceptions of many kinds
        return {"error": f"{type(error).__name__}: {error}".strip().splitlines()[0]}


def _write_answer(folder: Path, answer: dict[str, Any]) -> None:
    part = folder / "answer.part"
    part.write_text(json.dumps(answer), encoding="utf-8")
    part.replace(folder / "answer.json")


def _limit_memory(limit: float) -> None:
    """Let allocations beyond ``limit`` bytes fail, where the system can do that."""
    try:
        import resource
    except ImportError:
        return
    resource.setrlimit(resource.RLIMIT_AS, (int(limit), int(limit)))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
