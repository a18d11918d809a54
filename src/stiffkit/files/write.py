"""Writing YAML for people: whole or not at all, rows of numbers on one line."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from stiffkit.errors import OutputError


class Row(list[float]):
    """Numbers that are written on one line."""


class _Dumper(yaml.SafeDumper):
    """Knows rows, and writes twice what stands twice."""

    def ignore_aliases(self, data: object) -> bool:  # noqa: ARG002
        return True


_Dumper.add_representer(
    Row,
    lambda dumper, row: dumper.represent_sequence("tag:yaml.org,2002:seq", row, flow_style=True),
)


def write_yaml(content: Mapping[str, Any], path: Path) -> None:
    """Write plain values and rows to a file. Raises OutputError where that is not possible."""
    text = yaml.dump(
        dict(content), Dumper=_Dumper, sort_keys=False, width=10_000, allow_unicode=True
    )
    write_bytes(text.encode("utf-8"), path)


def write_bytes(content: bytes, path: Path) -> None:
    """Write a file whole or not at all. Raises OutputError where that is not possible."""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".partial")
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(content)
            Path(name).chmod(0o644)
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OutputError(f"cannot write {path}: {error.strerror}") from None
