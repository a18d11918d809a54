"""Every key of every kind of file is described, for editors and for the reference."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from docs._ext.file_keys import SCHEMAS, read_schema

from stiffkit.design import read as design_read
from stiffkit.design.uncertainty import read as uncertainty_read
from stiffkit.fea import link_spec
from stiffkit.study.sweep import read as sweep_read

QUANTITIES = {"quantity", "vector", "error"}


def nodes(node: Any, path: str = "") -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield everything that stands under ``properties``, with its path."""
    if isinstance(node, list):
        for one in node:
            yield from nodes(one, path)
    elif isinstance(node, dict):
        properties = node.get("properties")
        for key, value in properties.items() if isinstance(properties, dict) else ():
            yield f"{path}.{key}", value
        for key, value in node.items():
            if key not in {"examples", "default", "enum"}:
                yield from nodes(value, f"{path}.{key}")


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_key_is_described(kind: str) -> None:
    found = dict(nodes(read_schema(kind)))
    assert len(found) > 5
    assert [path for path, value in found.items() if len(value.get("description", "")) < 8] == []
    parts = read_schema(kind)["$defs"]
    assert [name for name, part in parts.items() if "description" not in part] == []


@pytest.mark.parametrize("kind", SCHEMAS)
def test_every_quantity_has_a_dimension(kind: str) -> None:
    without = [
        path
        for path, value in nodes(read_schema(kind))
        if str(value.get("$ref", "")).rpartition("/")[2] in QUANTITIES and "dimension" not in value
    ]
    assert without == []


@pytest.mark.parametrize(
    ("kind", "key", "default"),
    [
        ("study", "postures", sweep_read.POSTURES),
        ("design", "postures", design_read.POSTURES),
        ("uncertainty", "postures", uncertainty_read.POSTURES),
        ("uncertainty", "samples", uncertainty_read.SAMPLES),
        ("uncertainty", "sampled postures", uncertainty_read.SAMPLED_POSTURES),
        ("cad", "modes", link_spec.MODES),
    ],
)
def test_defaults_are_those_of_the_program(kind: str, key: str, default: int) -> None:
    assert read_schema(kind)["properties"][key]["default"] == default


@pytest.mark.parametrize(
    ("kind", "key", "share"),
    [
        ("cad", "tolerance", link_spec.TOLERANCE),
        ("uncertainty", "confidence", uncertainty_read.CONFIDENCE),
    ],
)
def test_default_shares_are_those_of_the_program(kind: str, key: str, share: float) -> None:
    told = str(read_schema(kind)["properties"][key]["default"])
    assert float(told.removesuffix(" %")) / 100 == pytest.approx(share)
