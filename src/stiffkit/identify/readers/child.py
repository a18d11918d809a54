"""The child process of ``isolated``: ``python -m ... READER FILE FOLDER [BULK]``."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import FileError, StiffkitError
from stiffkit.identify.readers import mesh, op2, rst
from stiffkit.identify.readers.content import FieldFile
from stiffkit.identify.readers.isolated import ARRAYS, ERROR
from stiffkit.identify.readers.source import available_memory

Read = Callable[[Path, Path | None], FieldFile]

READERS: dict[str, Read] = {"mesh": mesh.read, "op2": op2.read, "rst": rst.read}


def _store(file: FieldFile, arrays: Path) -> None:
    """Write content for the parent."""
    groups = {"cases": file.cases, "sets": file.sets, "facets": file.facets}
    told = {"format": file.format, **{group: list(held) for group, held in groups.items()}}
    listed = {
        f"{group}{place}": array
        for group, held in groups.items()
        for place, array in enumerate(held.values())
    }
    np.savez(arrays, told=json.dumps(told), ids=file.ids, points=file.points, **listed)  # type: ignore[arg-type]


def _limit_memory() -> None:
    """Let the process have what is free, so that a small file cannot fill the computer."""
    try:
        import resource
    except ImportError:
        return
    free = available_memory()
    if free is not None:
        resource.setrlimit(resource.RLIMIT_AS, (free, free))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _one_line(error: BaseException) -> str:
    """Return kind and first line of a stranger's error."""
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0][:200]}" if lines else type(error).__name__


def _read_or_tell(read: Read, path: Path, folder: Path, bulk: Path | None) -> dict[str, Any] | None:
    """Write the content for the parent, or return what is wrong."""
    try:
        _store(read(path, bulk), folder / ARRAYS)
    except FileError as error:
        where = str(error.path)
        return {"what": error.what, "path": where, "line": error.line, "mend": error.mend}
    except StiffkitError as error:
        return {"what": error.what, "path": None, "line": None, "mend": error.mend}
    except ModuleNotFoundError as error:
        what = f"reading this takes the library {error.name}, which is not installed"
        return {"what": what, "path": None, "line": None, "mend": f"pip install {error.name}"}
    except MemoryError:
        what, mend = "its content does not fit into memory", "export less"
    except (Exception, SystemExit) as error:
        what = f"it cannot be read: {_one_line(error)}"
        mend = "the file is cut off, damaged or of another format: export it again"
    else:
        return None
    return {"what": what, "path": str(path), "line": None, "mend": mend}


def _main(reader: str, path: str, folder: str, bulk: str | None = None) -> None:
    """Do the child's work."""
    _limit_memory()
    told = _read_or_tell(
        READERS[reader], Path(path), Path(folder), None if bulk is None else Path(bulk)
    )
    if told is not None:
        Path(folder, ERROR).write_text(json.dumps(told), encoding="utf-8")


if __name__ == "__main__":
    _main(*sys.argv[1:])
