"""From a robot file to a robot."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from stiffkit.errors import UnitError
from stiffkit.files.entry import Entry, Scope
from stiffkit.files.expressions import RESERVED_NAMES
from stiffkit.files.names import suggest
from stiffkit.files.parameters import Given, ParameterError, check_same_dimension, resolve
from stiffkit.files.schema import check_shape
from stiffkit.files.source import Source, read_source
from stiffkit.files.tree import read_tree
from stiffkit.link.materials import Material
from stiffkit.link.written import read_materials
from stiffkit.progress import Progress
from stiffkit.robot.catalogue import find_robot
from stiffkit.robot.dependence import Dependence, dependence
from stiffkit.robot.joints import check_connected, read_joints
from stiffkit.robot.links import read_links
from stiffkit.robot.memo import PartMemo
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
    return RobotFile(path_or_name).robot(parameters, progress)


class RobotFile:
    """A robot file that has been read once, for robots with any values of its parameters.

    Of each further robot only those parts are read again in which a changed parameter stands.
    """

    def __init__(self, path_or_name: str | Path) -> None:
        """Read a file, or one of the catalogue by its name, and check its shape.

        Raises FileError where it cannot be read or its shape is wrong.
        """
        self.path = find_robot(path_or_name)
        self.source = read_source(self.path)
        root = read_tree(self.source)
        check_shape(root, self.path, SCHEMA_FILE)
        self._root = Entry(self.path, (), root)
        self._parameters = _Parameters(self._root)
        self._memo = PartMemo()
        self._connected = False

    def robot(
        self, parameters: Mapping[str, Given] | None = None, progress: Progress | None = None
    ) -> Robot:
        """Return the robot with some parameters replaced; see `load_robot`.

        Raises FileError where there can be no such robot.
        """
        values, notes = self._parameters.replaced(parameters or {})
        entry = replace(self._root, scope=Scope(values))
        link_entries = read_parts(entry, "links")
        if not link_entries:
            raise entry.error("the robot has no links", "add a section 'links'")
        joint_entries = read_parts(entry, "joints")
        links, link_notes = read_links(
            link_entries,
            self._materials(entry),
            progress,
            self._memo,
            lambda others: self._parameters.replaced({**(parameters or {}), **others})[0],
        )
        joints = read_joints(joint_entries, links, self._memo)
        if not self._connected:
            check_connected(joints, links, link_entries)
            self._connected = True
        tool, home, loads = entry["tool"], entry.get("home"), entry.get("loads")
        workspace = entry.get("workspace")
        carrier = links.get(tool["at"].text().partition(".")[0])
        once = self._memo.get
        return Robot(
            name=self.path.stem,
            title=entry["robot"].text(),
            links=links,
            joints=joints,
            tool=once("tool", [tool], lambda: read_tool(tool, links), carrier),
            home=once("home", _given_entries(home), lambda: read_home(home, joints)),
            workspace=once(
                "workspace", _given_entries(workspace), lambda: read_workspace(workspace)
            ),
            loads=once("loads", _given_entries(loads), lambda: read_loads(loads)),
            parameters={
                name: Parameter(name, value.si, value.unit) for name, value in values.items()
            },
            source=self.path,
            content_hash=_hash_of_all(self.source, links),
            lines={section: given.node.line for section, given in entry.items()},
            notes=(*notes, *link_notes),
        )

    def parameters(self, given: Mapping[str, Given] | None = None) -> dict[str, Value]:
        """Return the values of all parameters, with some of them replaced.

        Raises FileError where that cannot be.
        """
        return self._parameters.replaced(given or {})[0]

    def dependence(self) -> Dependence:
        """Return which parameters follow from others, and what parts from CAD have to do with them.

        Raises FileError where ranges of parts cannot be read.
        """
        return dependence(
            replace(self._root, scope=Scope(self._parameters.values)), self._parameters.given
        )

    def _materials(self, entry: Entry) -> dict[str, Material]:
        given = entry.get("materials")
        return self._memo.get("materials", _given_entries(given), lambda: read_materials(given))


def _given_entries(entry: Entry | None) -> list[Entry]:
    return [] if entry is None else [entry]


def _hash_of_all(source: Source, links: Mapping[str, Link]) -> str:
    """Return the hash of a robot file and of the link files that it takes."""
    hashes = [link.content_hash for link in links.values() if link.content_hash]
    if not hashes:
        return source.content_hash
    return hashlib.sha256("".join([source.content_hash, *hashes]).encode()).hexdigest()


class _Parameters:
    """The parameters of a file, and what they are with others in their place."""

    def __init__(self, root: Entry) -> None:
        section = root.get("parameters")
        self.root = root
        self.entries = {} if section is None else dict(section.items())
        for name in sorted(self.entries.keys() & RESERVED_NAMES):
            raise self.entries[name].error(
                f"'{name}' is a function or a constant", "choose another name for the parameter"
            )
        self.given = {name: _given(entry) for name, entry in self.entries.items()}
        self.values = _resolve(self.given, self.entries)

    def replaced(self, overrides: Mapping[str, Given]) -> tuple[dict[str, Value], list[str]]:
        """Return the values of the parameters, and notes on those that were replaced."""
        for name in sorted(overrides.keys() - self.entries.keys()):
            raise self.root.error(
                f"the robot has no parameter '{name}'", suggest(name, self.entries)
            )
        if not overrides:
            return self.values, []
        replaced = _resolve({**self.given, **overrides}, self.entries)
        for name in overrides:
            try:
                check_same_dimension(name, self.values[name], replaced[name])
            except UnitError as error:
                raise self.entries[name].error(error.what, error.mend) from None
        return replaced, [
            f"parameters.{name}: {self.values[name]} replaced by {replaced[name]}"
            for name in overrides
        ]


def _given(entry: Entry) -> Given:
    value = entry.node.value
    return value if isinstance(value, str | int | float) else entry.value()


def _resolve(given: Mapping[str, Given], entries: Mapping[str, Entry]) -> dict[str, Value]:
    try:
        return resolve(given)
    except ParameterError as error:
        raise entries[error.name].error(error.what, error.mend) from None
