"""Ports that a robot file names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from stiffkit.files.entry import Entry
from stiffkit.files.names import suggest
from stiffkit.robot.model import BASE, Link
from stiffkit.spatial import Frame


@dataclass(frozen=True, eq=False)
class Port:
    """Where a joint or the tool attaches."""

    body: str
    name: str
    T_body_port: Frame


def read_port(entry: Entry, links: Mapping[str, Link]) -> Port:
    """Return the port that a text ``LINK``, ``LINK.PORT`` or ``base`` names.

    Raises FileError where there is no such link or port.
    """
    body, _, name = entry.text().partition(".")
    name = name or BASE
    if body == BASE:
        if name != BASE:
            raise entry.error(
                f"the base has no port '{name}'", "write 'base', and give the place by 'at'"
            )
        return Port(BASE, BASE, Frame())
    if body not in links:
        raise entry.error(f"there is no link '{body}'", suggest(body, [*links, BASE]))
    ports = links[body].ports
    if name not in ports:
        raise entry.error(f"link '{body}' has no port '{name}'", suggest(name, ports))
    return Port(body, name, ports[name])
