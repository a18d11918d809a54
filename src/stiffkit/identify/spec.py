"""Specifications of identifications: which fields, which loads, which nodes, in a file."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stiffkit.errors import FieldError, UnitError
from stiffkit.files import Entry, check_shape, read_frame, read_source, read_tree
from stiffkit.files.shares import read_share
from stiffkit.identify.estimators import Estimator
from stiffkit.identify.identified import Options
from stiffkit.identify.intervals import THREE_SIGMA
from stiffkit.identify.selection import Box, InSet, Layer, Listed, Near, Region, Sphere
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.units import FORCE, LENGTH, MOMENT, NUMBER, to_si

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema of specifications."""

ESTIMATORS: Mapping[str, Estimator] = {
    "lin": "LIN",
    "exact": "exact",
    "svd+": "SVD+",
    "svd-": "SVD-",
    "svd+-": "SVD+-",
}
"""The estimators by the words of a specification."""

_UNIT_NAME = re.compile(r"[^\d\s].*")


@dataclass(frozen=True)
class FieldSource:
    """A file of displacements, and what is taken from it."""

    place: Entry
    """Where the specification names it."""
    path: Path
    format: str | None = None
    bulk: Path | None = None
    cases: tuple[str, ...] | None = None
    """Names of the load cases that are taken; None for all."""
    name: str | None = None
    """A new name for the only load case."""


@dataclass(frozen=True)
class NodeChoice:
    """Which nodes a deflection is read from, and what each counts."""

    place: Entry
    """Where the specification says so."""
    regions: tuple[Region, ...]
    weights: str
    """equal, area or volume."""


@dataclass(frozen=True, eq=False)
class LoadSource:
    """The load of a load case."""

    place: Entry
    """Where the specification gives it."""
    wrench: Array
    """(6,), N and N m, at the reference point, in the axes of the files."""


@dataclass(frozen=True, eq=False)
class Spec:
    """A specification: all in SI; places and loads in the axes of the field files."""

    path: Path
    title: str
    length: float
    """m, the files' unit of length."""
    displacement: float
    """m, the files' unit of displacements."""
    fields: tuple[FieldSource, ...]
    sets: tuple[FieldSource, ...]
    """Input decks with node sets."""
    T_file_base: Frame
    """The link's frame in the axes of the files."""
    reference: Array
    """(3,), m."""
    nodes: NodeChoice
    compare: Mapping[str, NodeChoice]
    loads: Mapping[str, LoadSource] | tuple[LoadSource, ...]
    """By the names of load cases, or in the order of these."""
    options: Options
    symmetrize: bool
    clean: bool
    content_hash: str
    """SHA-256 of the file."""
    entry: Entry
    """The whole file, for errors with their place."""

    @property
    def name(self) -> str:
        """The file's name without what follows its first dot; results are called so."""
        return self.path.name.partition(".")[0] or "identified"

    def place(self, key: str) -> Entry:
        """Return the place of a key, or the whole file where the key is not given."""
        return self.entry.get(key) or self.entry


def read_spec(path: Path | str) -> Spec:
    """Return the specification of a file.

    Raises FileError, with the place and how to mend it, where anything is wrong.
    """
    source = read_source(Path(path))
    root = read_tree(source, "identify: TITLE")
    check_shape(root, source.path, SCHEMA_FILE)
    entry = Entry(source.path, (), root)
    length = _unit(entry["units"]["length"])
    given = entry["units"].get("displacement")
    reference = entry["reference"].vector(LENGTH)
    nodes = _choice(entry, reference, NodeChoice(entry, (), "equal"))
    compared = entry.get("compare")
    return Spec(
        path=source.path,
        title=entry["identify"].text(),
        length=length,
        displacement=length if given is None else _unit(given),
        fields=tuple(_field(one) for one in _one_or_several(entry["fields"])),
        sets=tuple(_file(one) for one in _one_or_several(entry.get("sets"))),
        T_file_base=Frame() if "base" not in entry else read_frame(entry["base"]),
        reference=reference,
        nodes=nodes,
        compare={
            name: _choice(one, reference, nodes)
            for name, one in ([] if compared is None else compared.items())
        },
        loads=_loads(entry["loads"], reference),
        options=_options(entry),
        symmetrize=_truth(entry.get("symmetrize"), default=True),
        clean=_truth(entry.get("clean"), default=False),
        content_hash=source.content_hash,
        entry=entry,
    )


@contextmanager
def blamed_on(entry: Entry) -> Iterator[None]:
    """Tell what is wrong with a field, inside, as an error of the place in the specification."""
    try:
        yield
    except FieldError as error:
        raise entry.error(error.what, error.mend) from None


def _one_or_several(entry: Entry | None) -> list[Entry]:
    if entry is None:
        return []
    return entry.elements() if isinstance(entry.node.value, list) else [entry]


def _unit(entry: Entry) -> float:
    """Return the size in m of a unit of length."""
    text = entry.text()
    try:
        if not _UNIT_NAME.fullmatch(text):
            raise UnitError(f"'{text}' is not the name of a unit", mend="write for example 'mm'")
        return to_si(f"1 {text}", LENGTH)
    except UnitError as error:
        raise entry.error(error.what, error.mend) from None


def _file(entry: Entry) -> FieldSource:
    path = entry.path.parent / entry.text()
    if not path.exists():
        raise entry.error(
            f"there is no file '{path}'", "its name is taken relative to the specification"
        )
    return FieldSource(entry, path)


def _field(entry: Entry) -> FieldSource:
    if isinstance(entry.node.value, str):
        return _file(entry)
    cases = entry.get("cases")
    name, format = entry.get("name"), entry.get("format")
    return FieldSource(
        entry,
        _file(entry["file"]).path,
        format=None if format is None else format.text(),
        bulk=None if (bulk := entry.get("bulk")) is None else _file(bulk).path,
        cases=None if cases is None else tuple(one.text() for one in cases.elements()),
        name=None if name is None else name.text(),
    )


def _choice(entry: Entry, reference: Array, otherwise: NodeChoice) -> NodeChoice:
    """Return a choice of nodes; what it leaves out is as in another."""
    given, weights = entry.get("select"), entry.get("weights")
    return NodeChoice(
        entry if given is None else given,
        otherwise.regions if given is None else tuple(_regions(given, reference)),
        otherwise.weights if weights is None else weights.text(),
    )


def _regions(entry: Entry, reference: Array) -> Iterator[Region]:
    readers: Mapping[str, Callable[[Entry], Region]] = {
        "set": lambda one: InSet(one.text()),
        "nodes": lambda one: Listed(tuple(int(node.value().si) for node in one.elements())),
        "box": lambda one: Box(_point(one[0]), _point(one[1])),
        "sphere": lambda one: Sphere(_point(one["at"]), one["radius"].quantity(LENGTH)),
        "near": lambda one: Near(_triple(reference), one.quantity(LENGTH)),
        "layer": lambda one: _layer(one, reference),
    }
    for kind, given in entry.items():
        with blamed_on(given):
            yield readers[kind](given)


def _layer(entry: Entry, reference: Array) -> Layer:
    at, thickness = entry.get("at"), entry.get("thickness")
    return Layer(
        _triple(reference) if at is None else _point(at),
        _triple(entry["normal"].vector(NUMBER)),
        0.0 if thickness is None else thickness.quantity(LENGTH),
    )


def _point(entry: Entry) -> tuple[float, float, float]:
    return _triple(entry.vector(LENGTH))


def _triple(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


def _loads(entry: Entry, reference: Array) -> Mapping[str, LoadSource] | tuple[LoadSource, ...]:
    if isinstance(entry.node.value, list):
        return tuple(_load(one, reference) for one in entry.elements())
    return {name: _load(one, reference) for name, one in entry.items()}


def _load(entry: Entry, reference: Array) -> LoadSource:
    force, moment, at = entry.get("force"), entry.get("moment"), entry.get("at")
    F = np.zeros(3) if force is None else force.vector(FORCE)
    M = np.zeros(3) if moment is None else moment.vector(MOMENT)
    if at is not None:
        M = M + np.cross(at.vector(LENGTH) - reference, F)
    return LoadSource(entry, np.concatenate([F, M]))


def _options(entry: Entry) -> Options:
    outliers, level = entry.get("outliers"), entry.get("confidence")
    dropped = None if outliers is None else outliers.get("drop")
    treatment = "keep" if outliers is None else outliers.text()
    if dropped is None and outliers is not None and treatment not in ("keep", "robust"):
        raise outliers.error(
            f"there is no treatment of outliers '{treatment}'",
            "write 'keep', 'robust', or {drop: 10 %}",
        )
    robust = dropped is None and treatment == "robust"
    estimator = entry.get("estimator")
    if robust and estimator is not None and estimator.text() != "lin":
        raise estimator.error(
            f"a robust fit is linear, and the estimator is {estimator.text()}",
            "write 'estimator: lin', or drop outliers",
        )
    sigma = entry.get("sigma")
    drop_share = 0.1 if dropped is None else read_share(dropped, most=0.5, example=0.1)
    return Options(
        estimator=ESTIMATORS["lin" if estimator is None else estimator.text()],
        level=THREE_SIGMA if level is None else read_share(level, most=1.0, example=0.95),
        pooled=sigma is None or sigma.text() == "pooled",
        outliers="drop" if dropped is not None else "robust" if robust else "keep",
        drop_percent=100.0 * drop_share,
    )


def _truth(entry: Entry | None, default: bool) -> bool:
    return default if entry is None else bool(entry.node.value)
