"""The web server of the studio: viser's, let in by us.

A page on the web can make a browser send requests to a server on the same computer. So a request is
answered only where it names this server as its host, and, if it comes from a page, as that page's
origin. A name that leads here by somebody else's domain name server is no such name.
"""

from __future__ import annotations

import contextlib
import http
import http.client
import io
import ipaddress
from collections.abc import Callable
from types import ModuleType
from typing import TYPE_CHECKING, Any
from unittest.mock import patch
from urllib.parse import urlsplit

from stiffkit.errors import StiffkitError, how_to_install, optional

if TYPE_CHECKING:
    import viser
    from websockets.asyncio.server import ServerConnection
    from websockets.datastructures import Headers
    from websockets.http11 import Request, Response

    Answer = Callable[[ServerConnection, Request], Response | None]

LOOPBACK = "127.0.0.1"
DEFAULT_PORT = 8090

_LOCAL_NAMES = frozenset({"localhost", "127.0.0.1", "::1"})
_FOREIGN = "a-page-of-somebody-else.invalid"


def start_server(host: str = LOOPBACK, port: int = DEFAULT_PORT) -> viser.ViserServer:
    """Return a running server; the next free port is taken where ``port`` is not.

    ``host`` is the address to listen at: by default this computer alone can reach it. Raises
    StiffkitError where that is no address of this computer.
    """
    library = viser_library()
    _check_address(host, port)
    with _guarded(host), contextlib.redirect_stdout(io.StringIO()):
        server: viser.ViserServer = library.ViserServer(host=host, port=port, verbose=False)
    _close_ways_out(server)
    if not _refuses_others(server):
        stop_server(server)
        raise StiffkitError(
            "the studio's server does not refuse requests from other pages",
            mend=f"install the version of viser that stiffkit was made for: "
            f"{how_to_install('studio')}",
        )
    return server


def viser_library() -> ModuleType:
    """Return viser, which is an extra. Raises MissingExtraError without it."""
    with optional("viser", needed_for="the studio in the browser", extra="studio"):
        import viser
    return viser


def stop_server(server: viser.ViserServer) -> None:
    """End a server, which would say good-bye on the terminal."""
    with contextlib.redirect_stdout(io.StringIO()):
        server.stop()


def address_of(server: viser.ViserServer) -> str:
    """Return the address that a browser on this computer opens."""
    host = server.get_host()
    is_everywhere = host in ("0.0.0.0", "::")  # noqa: S104  # compared, not listened at
    shown = "localhost" if is_everywhere else f"[{host}]" if ":" in host else host
    return f"http://{shown}:{server.get_port()}"


def is_allowed(headers: Headers | dict[str, str], host: str) -> bool:
    """Tell whether a request with these headers may be answered by a server at ``host``."""
    asked = urlsplit(f"//{headers.get('Host', '')}")
    if not _is_own_name(asked.hostname, host):
        return False
    origin = headers.get("Origin")
    return origin is None or urlsplit(origin).netloc == asked.netloc


def _is_own_name(name: str | None, host: str) -> bool:
    """Tell whether ``name`` can only mean this server: its address, or the computer's own names."""
    if name is None:
        return False
    if name in _LOCAL_NAMES or name == host:
        return True
    # Who listens at a network's address is reached by that address, as a number.
    listens_to_network = host not in _LOCAL_NAMES
    return listens_to_network and _is_number(name)


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


@contextlib.contextmanager
def _guarded(host: str) -> Any:
    """Let every server that is started meanwhile refuse what is not allowed.

    viser makes its server deep inside and offers no place for such a check.
    """
    from websockets.asyncio import server as websockets_server

    class Guarded(websockets_server.serve):
        def __init__(self, *args: Any, process_request: Answer, **options: Any) -> None:
            def answer(connection: ServerConnection, request: Request) -> Response | None:
                if not is_allowed(request.headers, host):
                    return connection.respond(http.HTTPStatus.FORBIDDEN, "not from this page\n")
                return process_request(connection, request)

            super().__init__(*args, process_request=answer, **options)

    with patch.object(websockets_server, "serve", Guarded):
        yield


def _close_ways_out(server: viser.ViserServer) -> None:
    """Take away viser's offer to share the page through a server of others."""
    from viser import _messages

    for kind in (_messages.ShareUrlRequest, _messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(kind)


def _refuses_others(server: viser.ViserServer) -> bool:
    """Ask the server as a page of somebody else would, and tell whether it refuses."""
    host = server.get_host()
    address = LOOPBACK if host == "0.0.0.0" else host  # noqa: S104
    for headers in ({"Origin": f"http://{_FOREIGN}"}, {"Host": _FOREIGN}):
        connection = http.client.HTTPConnection(address, server.get_port(), timeout=10)
        try:
            connection.request("GET", "/", headers=headers)
            if connection.getresponse().status != http.HTTPStatus.FORBIDDEN:
                return False
        finally:
            connection.close()
    return True


def _check_address(host: str, port: int) -> None:
    """Raise StiffkitError where nothing can listen, which viser would try again and again."""
    import socket

    try:
        family = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as probe:
            probe.bind((host, 0))
    except OSError as error:
        raise StiffkitError(
            f"nothing can listen at {host}: {error.strerror or error}",
            mend="leave --host out, or give an address of this computer",
        ) from None
    if not 0 <= port <= 65535:
        raise StiffkitError(f"there is no port {port}", mend="choose one from 1024 to 65535")
