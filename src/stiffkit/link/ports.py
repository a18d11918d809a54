"""The ports of elastic links: how files name them, and their motions relative to the base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stiffkit.files import Entry, Row, read_frame
from stiffkit.spatial import Frame, twist_shift
from stiffkit.spatial.rotation import Array
from stiffkit.units import LENGTH

BASE = "base"
"""The port at the link's origin, which is held where a compliance is meant."""
TIP = "tip"
"""The other port of a link that has two."""

_WAYS = ("tip", "length", "ports")


def read_ports(entry: Entry) -> dict[str, Frame]:
    """Return T_link_port of the ports but the base, in the order of the compliance.

    A mapping gives one port by ``tip`` or by ``length``, any number by ``ports``. Raises FileError
    where it gives none, or in several ways.
    """
    given = [way for way in _WAYS if way in entry]
    if not given:
        raise entry.error(
            "no 'tip', 'length' or 'ports' is given",
            "say where the tip is by 'tip' or 'length', or where several ports are by 'ports'",
        )
    if len(given) > 1:
        raise entry.error(f"'{given[0]}' and '{given[1]}' are both given", "keep one of the two")
    if given[0] == "length":
        return {TIP: Frame.at(entry["length"].positive(LENGTH))}
    if given[0] == "tip":
        return {TIP: read_frame(entry["tip"])}
    return {name: read_frame(port) for name, port in other_ports(entry["ports"])}


def other_ports(entry: Entry) -> list[tuple[str, Entry]]:
    """Return the entries of a ``ports`` mapping. Raises FileError where one of them is the base."""
    ports = list(entry.items())
    for name, port in ports:
        if name == BASE:
            raise port.error(
                f"'{BASE}' is the port at the link's origin, which is held",
                "name the other ports only, or give this one another name",
            )
    return ports


def write_ports(ports: Mapping[str, Frame]) -> dict[str, Any]:
    """Return ports but the base as files write them: a ``tip`` if that is all there is."""
    written = {name: _write_frame(frame) for name, frame in ports.items()}
    return written if list(written) == [TIP] else {"ports": written}


def _write_frame(frame: Frame) -> dict[str, Any]:
    """Return a frame's place, and the turns about x, y and z that make its rotation, if any."""
    from scipy.spatial.transform import Rotation

    place: dict[str, Any] = {"at": Row(frame.position.tolist())}
    if not np.array_equal(frame.rotation, np.eye(3)):
        angles = Rotation.from_matrix(frame.rotation).as_euler("XYZ")
        place["rotate"] = [{axis: float(a)} for axis, a in zip("xyz", angles, strict=True)]
    return place


def places_of(ports: Mapping[str, Frame]) -> Array:
    """Return the origins (p, 3) of ports, m."""
    return np.array([frame.position for frame in ports.values()]).reshape(-1, 3)


def carried(places: ArrayLike) -> Array:
    """Return the twists (6p, 6) of ports at ``places`` (p, 3) when all moves with the base."""
    return np.vstack([twist_shift(place) for place in np.reshape(places, (-1, 3))])


def relative_to_base(places: ArrayLike) -> Array:
    """Return B (6p, 6 + 6p): twists of base and ports to those of the ports relative to the base.

    Twists are in link axes, of the base at the origin and of the ports at ``places`` (p, 3).
    """
    motions = carried(places)
    return np.hstack([-motions, np.eye(len(motions))])


def in_words(names: Sequence[str]) -> str:
    """Return names as "left", "left and right", "left, right and tool"."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last
