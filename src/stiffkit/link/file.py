"""Link files: a link's compliance, mass and superelement, with where they come from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from stiffkit.errors import FileError
from stiffkit.files import Entry, Row, check_shape, read_source, read_tree, write_yaml
from stiffkit.link.given import read_compliance, read_inertia
from stiffkit.link.given_superelement import (
    check_superelement,
    doubts_superelement,
    given_superelement,
    rigid_body_of,
)
from stiffkit.link.matrix_file import read_matrix
from stiffkit.link.ports import places_of, read_ports, write_ports
from stiffkit.link.superelement import Superelement
from stiffkit.spatial import Frame
from stiffkit.spatial.rotation import Array
from stiffkit.units import LENGTH, MASS

Ports = dict[str, Frame]

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema of link files."""

SUFFIX = ".link.yaml"

_DISAGREEMENT = 0.01
"""Relative difference of the compliances of one file that is worth a note."""


@dataclass(frozen=True, eq=False)
class LinkFile:
    """An elastic link with m ports: everything in link axes, SI."""

    title: str
    ports: Mapping[str, Frame]
    """T_link_port of the ports but the base, which is at the link's origin."""
    compliance: Array
    """(6(m-1), 6(m-1)), of these ports, in order, each at its origin, with the base clamped."""
    covariance: Array | None = None
    """(36, 36), of the elements of the compliance of a link with two ports, row by row."""
    mass: float | None = None
    """kg."""
    center_of_mass: Array | None = None
    """(3,), m."""
    inertia: Array | None = None
    """(3, 3), kg m^2, about the centre of mass."""
    superelement: Superelement | None = None
    provenance: Mapping[str, Any] = field(default_factory=dict)
    """How the numbers were found: plain values by name."""
    notes: tuple[str, ...] = ()
    """Repairs that the file asked for, and doubts."""
    content_hash: str = ""
    """SHA-256 of the file."""


def read_link_file(path: Path) -> LinkFile:
    """Return the link of a file.

    Raises FileError, with the place and how to mend it, where anything is wrong.
    """
    source = read_source(path)
    root = read_tree(source, "link: TITLE")
    check_shape(root, path, SCHEMA_FILE)
    entry = Entry(path, (), root)
    if "compliance" not in entry and "superelement" not in entry:
        raise entry.error("the link has no elasticity", "add 'compliance' or 'superelement'")
    notes: list[str] = []
    element: Superelement | None = None
    ports: Ports = {}
    if (given := entry.get("superelement")) is not None:
        element, ports, notes = _read_superelement(given)
        compliance = element.compliance
    if (given := entry.get("compliance")) is not None:
        own = read_ports(given)
        if element is not None and not _are_at_one_place(own, ports):
            raise given.error(
                "its ports are not those of the superelement", "give the same ports twice"
            )
        ports = own
        compliance, repairs = read_compliance(given, list(ports))
        notes.extend(repairs)
    mass, center, found_inertia = _read_mass(entry, element, ports, notes)
    if element is not None:
        notes.extend(_disagreement(compliance, element.compliance))
    return LinkFile(
        title=entry["link"].text(),
        ports=ports,
        compliance=compliance,
        covariance=_read_covariance(entry.get("covariance"), ports),
        mass=mass,
        center_of_mass=center,
        inertia=found_inertia,
        superelement=element,
        provenance=_provenance(entry),
        notes=tuple(notes),
        content_hash=source.content_hash,
    )


def _are_at_one_place(first: Ports, second: Ports) -> bool:
    """Tell whether ports have the same names and places."""
    return list(first) == list(second) and np.allclose(
        places_of(first), places_of(second), atol=1e-9
    )


def _read_superelement(entry: Entry) -> tuple[Superelement, Ports, list[str]]:
    ports = read_ports(entry)
    K, M = read_matrix(entry["stiffness"]), read_matrix(entry["mass"])
    if "units" in entry and entry["units"].text() == "mm":
        K, M = (_from_mm(matrix, 1 + len(ports)) for matrix in (K, M))
    faults = check_superelement(K, M, ports)
    if faults:
        raise entry.error("; ".join(faults), "correct the matrices, their order or 'units'")
    element = given_superelement(K, M, 1 + len(ports))
    return element, ports, doubts_superelement(element, places_of(ports))


def _from_mm(matrix: Array, n_ports: int) -> Array:
    """Return a matrix (6m + n, 6m + n) of energy in mJ over mm and rad in J over m and rad."""
    coordinate = np.arange(len(matrix))
    scale = np.where((coordinate < 6 * n_ports) & (coordinate % 6 < 3), 1e3, 1.0)
    return np.asarray(1e-3 * matrix * np.outer(scale, scale))


def _read_mass(
    entry: Entry, element: Superelement | None, ports: Ports, notes: list[str]
) -> tuple[float | None, Array | None, Array | None]:
    given = [key for key in ("mass", "center_of_mass", "inertia") if key in entry]
    if element is not None:
        body = rigid_body_of(element, places_of(ports))
        own = entry["mass"].not_negative(MASS) if "mass" in entry else body.mass
        if abs(own - body.mass) > _DISAGREEMENT * body.mass:
            notes.append(f"mass: {own:.6g} kg is given, the superelement has {body.mass:.6g} kg")
        return body.mass, body.center_of_mass, body.inertia
    mass = entry["mass"].not_negative(MASS) if "mass" in given else None
    center = entry["center_of_mass"].vector(LENGTH) if "center_of_mass" in given else None
    if "inertia" not in given:
        return mass, center, None
    inertia, repairs = read_inertia(entry["inertia"], mass)
    notes.extend(repairs)
    return mass, center, inertia


def _read_covariance(entry: Entry | None, ports: Ports) -> Array | None:
    if entry is None:
        return None
    if len(ports) > 1:
        raise entry.error(
            "a covariance is known of links with two ports only, and this one has more",
            "leave it out",
        )
    covariance = np.array(entry.node.plain(), dtype=np.float64)
    if not np.isfinite(covariance).all() or (np.diag(covariance) < 0.0).any():
        raise entry.error("a covariance has finite values and no negative variances")
    return covariance


def _disagreement(given: Array, own: Array) -> list[str]:
    size = np.sqrt(np.diag(given))
    worst = float(np.max(np.abs(given - own) / np.outer(size, size)))
    if worst <= _DISAGREEMENT:
        return []
    return [
        f"the compliance differs from that of the superelement by up to {worst:.1%} of its"
        " diagonal; statics uses the compliance"
    ]


def _provenance(entry: Entry) -> dict[str, Any]:
    given = entry.get("provenance")
    plain = {} if given is None else given.node.plain()
    return plain if isinstance(plain, dict) else {}


def write_link_file(link: LinkFile, path: Path) -> None:
    """Write a link file, whole or not at all. Raises OutputError where that is not possible."""
    write_yaml(_content(link), path)


def _content(link: LinkFile) -> dict[str, Any]:
    content: dict[str, Any] = {"link": link.title}
    content["compliance"] = {"matrix": _rows(link.compliance)} | write_ports(link.ports)
    if link.mass is not None:
        content["mass"] = float(link.mass)
    if link.center_of_mass is not None:
        content["center_of_mass"] = Row(link.center_of_mass.tolist())
    if link.inertia is not None:
        content["inertia"] = _rows(link.inertia)
    if link.provenance:
        content["provenance"] = dict(link.provenance)
    if link.superelement is not None:
        element = link.superelement
        content["superelement"] = {
            "stiffness": _rows(element.stiffness(places_of(link.ports))),
            "mass": _rows(element.mass),
        } | write_ports(link.ports)
    if link.covariance is not None:
        content["covariance"] = _rows(link.covariance)
    return content


def _rows(matrix: Array) -> list[Row]:
    return [Row(row) for row in matrix.tolist()]


def is_link_file(text: str) -> bool:
    """Tell whether a text is meant as the name of a link file."""
    return text.endswith((".yaml", ".yml"))


def find_link_file(entry: Entry) -> Path:
    """Return the path that a text names, beside the file that it stands in.

    Raises FileError where it is no link file's name.
    """
    name = entry.text()
    if not is_link_file(name):
        raise entry.error(
            f"'{name}' is not the name of a link file",
            f"write a mapping with 'matrix', or the name of a file that ends in {SUFFIX}",
        )
    path = entry.path.parent / name
    if not path.exists():
        raise FileError(
            f"there is no link file '{path}'",
            path=entry.path,
            line=entry.node.line,
            key=entry.error("").key,
            mend="its name is taken relative to the file that names it",
        )
    return path
