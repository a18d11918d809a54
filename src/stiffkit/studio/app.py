"""The studio as a whole: a machine, a server and a session between them."""

from __future__ import annotations

import threading
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from stiffkit.files.parameters import Given
from stiffkit.progress import Progress, no_progress
from stiffkit.robot import load_robot
from stiffkit.studio.machine import Machine
from stiffkit.studio.saving import Saver
from stiffkit.studio.server import (
    DEFAULT_PORT,
    LOOPBACK,
    address_of,
    start_server,
    stop_server,
    viser_library,
)
from stiffkit.studio.session import Session

if TYPE_CHECKING:
    import viser

MOST_POINTS = 10_000
"""Poses of the workspace if nothing else is asked for: what a slider can move at once."""


class Studio:
    """A studio that runs, until it is closed."""

    def __init__(self, session: Session, server: viser.ViserServer) -> None:
        """Take what runs."""
        self._session = session
        self._server = server
        self.title = session.machine.robot.title
        self.address = address_of(server)
        """What a browser on this computer opens."""
        self.n_poses = session.n_poses
        """How many poses of the workspace are looked at."""

    def wait(self) -> None:
        """Wait until the program is interrupted."""
        threading.Event().wait()

    def drop_connections(self) -> None:
        """Cut all browsers off; they come back by themselves."""
        self._server._websock_server.disconnect_all_clients()

    def close(self) -> None:
        """End all threads and the server."""
        self._session.close()
        stop_server(self._server)


def open_studio(
    source: str | Path,
    given: Mapping[str, Given] | None = None,
    *,
    folder: Path,
    points: int | None = None,
    host: str = LOOPBACK,
    port: int = DEFAULT_PORT,
    progress: Progress = no_progress,
) -> Studio:
    """Open the studio on a robot file or a robot of the catalogue, and return it running.

    Args:
        source: the robot file, or the robot's name in the catalogue.
        given: values of parameters that sliders stand at in the beginning.
        folder: where it saves; it writes nowhere else.
        points: about how many poses of the workspace are looked at.
        host: the address to listen at; by default this computer alone reaches the studio.
        port: the port, or the next one that is free; 0 for any.
        progress: is told what is being done.

    Raises:
        MissingExtraError: if viser is not installed.
        FileError, AssemblyError, PoseError: where there can be no such robot.
        OutputError: if the folder is none.
        StiffkitError: where the server cannot listen.
    """
    # What is missing is told before the robot is made, which takes some seconds.
    viser_library()
    saver = Saver(folder, source)
    machine = Machine(source, points=MOST_POINTS if points is None else points, progress=progress)
    values = _values(source, given or {}, machine)
    server = start_server(host, port)
    try:
        return Studio(Session(machine, server, saver, values), server)
    except BaseException:
        stop_server(server)
        raise


def _values(source: str | Path, given: Mapping[str, Given], machine: Machine) -> dict[str, float]:
    """Return parameters that are given another value, SI."""
    if not given:
        return {}
    robot = load_robot(source, given)
    return {name: robot.parameters[name].value for name in given if name in machine.parameters}
