"""The house's rules: who may import whom, and what nobody does."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import stiffkit

PACKAGE = Path(stiffkit.__file__).parent

FLOORS = {
    "spatial": 0,
    "smallmat": 0,
    "units": 0,
    "errors": 0,
    "progress": 0,
    "compiled": 1,
    "files": 1,
    "link": 2,
    "identify": 3,
    "fea": 4,
    "robot": 5,
    "kinematics": 6,
    "network": 7,
    "stiffness": 8,
    "vibration": 8,
    "study": 9,
    "verify": 10,
    "design": 10,
    "plots": 11,
    "report": 12,
    "studio": 13,
    "reproduce": 12,
    "cli": 14,
}


def sources() -> Iterator[tuple[str, Path]]:
    """Room and path of each module but the package's own front door."""
    for path in sorted(PACKAGE.rglob("*.py")):
        relative = path.relative_to(PACKAGE)
        if relative.name != "__init__.py" or len(relative.parts) > 1:
            yield relative.parts[0].removesuffix(".py"), path


def imported(path: Path) -> Iterator[tuple[int, str]]:
    """Line and dotted name of everything that a module imports, wherever in it."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}:{node.lineno}: a relative import"
            for alias in node.names:
                yield node.lineno, f"{node.module}.{alias.name}"


def test_every_room_has_a_floor() -> None:
    for room, path in sources():
        assert room in FLOORS, f"{path}: the room '{room}' has no floor"


def test_a_room_imports_only_from_floors_below() -> None:
    for room, path in sources():
        for line, name in imported(path):
            parts = name.split(".")
            # The error classes lie under all rooms.
            if parts[0] != "stiffkit" or parts[1] in (room, "errors", "__version__"):
                continue
            assert FLOORS[parts[1]] < FLOORS[room], f"{path}:{line}: {room} imports {parts[1]}"


def test_libraries_stay_in_their_rooms() -> None:
    homes = {
        "pint": {"units"},
        "heyoka": {"compiled"},
        "click": {"cli"},
        "yaml": {"files"},
        "ngsolve": {"fea"},
        "netgen": {"fea"},
        "meshio": {"identify"},
        "pyNastran": {"identify"},
        "ansys": {"identify"},
        "pymoo": {"design"},
    }
    for room, path in sources():
        for line, name in imported(path):
            library = name.split(".")[0]
            assert room in homes.get(library, {room}), f"{path}:{line}: {room} imports {library}"


def test_nobody_evaluates_text_or_unpickles() -> None:
    for _, path in sources():
        for line, name in imported(path):
            library = name.split(".")[0]
            assert library not in ("pickle", "dill", "marshal", "shelve"), f"{path}:{line}"
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
                called = node.func.id
                assert called not in ("eval", "exec", "compile"), f"{path}:{node.lineno}: {called}"


def test_the_front_door_loads_nothing() -> None:
    code = (
        "import sys, stiffkit; "
        "print([m for m in sys.modules if m in ('numpy', 'heyoka', 'scipy', 'xarray')"
        " or m.startswith('stiffkit.')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_help_loads_nothing_heavy() -> None:
    code = (
        "import sys; from stiffkit.cli.commands import main; "
        "print([m for m in ('numpy', 'scipy', 'xarray', 'matplotlib', 'heyoka', 'pint')"
        " if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
