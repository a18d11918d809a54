"""From a robot file to a robot."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

from stiffkit.errors import UnitError
from stiffkit.files.entry import Entry, Scope
from stiffkit.files.expressions import RESERVED_NAMES
from stiffkit.files.names import suggest
from stiffkit.files.parameters import Given, ParameterError, check_same_dimension, resolve
from stiffkit.files.schema import check_shape
from stiffkit.files.source import Source, read_source
from stiffkit.files.tree import read_tree
from stiffkit.link.written import read_materials
from stiffkit.robot.catalogue import find_robot
from stiffkit.robot.joints import check_connected, read_joints
from stiffkit.robot.links import Progress, read_links
from stiffkit.robot.model import Link, Parameter, Robot
from stiffkit.robot.parts import read_parts
from stiffkit.robot.task import read_home, read_loads, read_tool, read_workspace
from stiffkit.units import Value

SCHEMA_FILE = Path(__file__).with_name("schema.json")
"""The published schema; editors that know JSON Schema complete and check robot files with it."""


def load_robot(
    path_or_name: str | Path,
    parameters: Mapping[str, Given] | None = None,
    progress: Progress | None = None,
) -> Robot:
    """Return the robot of a file, or of the catalogue by its name.

    ``parameters`` replace those of the file, such as ``{"base": "310 mm"}``; numbers are SI.
    Parts from CAD that have not been solved before are; ``progress`` is told what is being done
    and the share that is done. Raises FileError, with the place and how to mend it, where
    anything is wrong.
    """
    path = find_robot(path_or_name)
    source = read_source(path)
    root = read_tree(source)
    check_shape(root, path, SCHEMA_FILE)
    values, notes = _parameters(Entry(path, (), root), parameters or {})
    entry = Entry(path, (), root, Scope(values))
    link_entries = read_parts(entry, "links")
    if not link_entries:
        raise entry.error("the robot has no links", "add a section 'links'")
    joint_entries = read_parts(entry, "joints")
    links, link_notes = read_links(link_entries, read_materials(entry.get("materials")), progress)
    joints = read_joints(joint_entries, links)
    check_connected(joints, links, link_entries)
    return Robot(
        name=path.stem,
        title=entry["robot"].text(),
        links=links,
        joints=joints,
        tool=read_tool(entry["tool"], links),
        home=read_home(entry.get("home"), joints),
        workspace=read_workspace(entry.get("workspace")),
        loads=read_loads(entry.get("loads")),
        parameters={name: Parameter(name, value.si, value.unit) for name, value in values.items()},
        source=path,
        content_hash=_hash_of_all(source, links),
        lines={section: given.node.line for section, given in entry.items()},
        notes=(*notes, *link_notes),
    )


def _hash_of_all(source: Source, links: Mapping[str, Link]) -> str:
    """Return the hash of a robot file and of the link files that it takes."""
    hashes = [link.content_hash for link in links.values() if link.content_hash]
    if not hashes:
        return source.content_hash
    return hashlib.sha256("".join([source.content_hash, *hashes]).encode()).hexdigest()


def _parameters(root: Entry, overrides: Mapping[str, Given]) -> tuple[dict[str, Value], list[str]]:
    """Return the values of the parameters, and notes on those that were replaced."""
    section = root.get("parameters")
    entries = {} if section is None else dict(section.items())
    for name in sorted(entries.keys() & RESERVED_NAMES):
        raise entries[name].error(
            f"'{name}' is a function or a constant", "choose another name for the parameter"
        )
    for name in sorted(overrides.keys() - entries.keys()):
        raise root.error(f"the robot has no parameter '{name}'", suggest(name, entries))
    given = {name: _given(entry) for name, entry in entries.items()}
    values = _resolve(given, entries)
    if not overrides:
        return values, []
    replaced = _resolve({**given, **overrides}, entries)
    for name in overrides:
        try:
            check_same_dimension(name, values[name], replaced[name])
        except UnitError as error:
            raise entries[name].error(error.what, error.mend) from None
    return replaced, [
        f"parameters.{name}: {values[name]} replaced by {replaced[name]}" for name in overrides
    ]


def _given(entry: Entry) -> Given:
    value = entry.node.value
    return value if isinstance(value, str | int | float) else entry.value()


def _resolve(given: Mapping[str, Given], entries: Mapping[str, Entry]) -> dict[str, Value]:
    try:
        return resolve(given)
    except ParameterError as error:
        raise entries[error.name].error(error.what, error.mend) from None
