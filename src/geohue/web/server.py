"""Running the application on a port of this machine."""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Callable
from secrets import token_urlsafe

from geohue.errors import GeohueError
from geohue.web.door import Door
from geohue.web.limits import Limits

LOOPBACK = "127.0.0.1"

_OWN_NAMES = frozenset({"127.0.0.1", "localhost", "::1"})
_ANYWHERE = ("0.0.0.0", "::")
_LAST_REQUESTS = 2  # seconds that open requests get at the end


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach a server at this address.

    Examples
    --------
    >>> is_loopback("127.0.0.1"), is_loopback("localhost"), is_loopback("0.0.0.0")
    (True, True, False)
    """
    if host == "localhost":
        return True
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def door_for(host: str, token: str = "") -> Door:
    """Return who is let in by a server at an address: beyond this machine only with a token.

    Parameters
    ----------
    host : str
        The address that it listens at.
    token : str
        What has to be known; made up where it is empty and one is needed.

    Examples
    --------
    >>> door_for("127.0.0.1").token
    ''
    >>> len(door_for("0.0.0.0").token)
    32
    """
    if is_loopback(host):
        return Door(_OWN_NAMES | {host}, token=token)
    names = {host, socket.gethostname(), f"{socket.gethostname()}.local"}
    named = frozenset(name.lower() for name in names - set(_ANYWHERE))
    return Door(_OWN_NAMES | named, any_address=True, token=token or token_urlsafe(24))


def listen(host: str, port: int) -> socket.socket:
    """Return a socket that listens at an address; port 0 takes any that is free.

    Raises
    ------
    GeohueError
        If the address or the port cannot be had.
    """
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        made = socket.socket(family, socket.SOCK_STREAM)
    except OSError as error:
        raise GeohueError(f"--host {host}: {error.strerror or error}; give an address") from error
    try:
        made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        made.bind((host, port))
        made.listen(128)
    except (OSError, OverflowError) as error:
        made.close()
        cause = getattr(error, "strerror", None) or error
        raise GeohueError(f"port {port} of {host}: {cause}; give another --port") from error
    return made


def serve(
    host: str,
    port: int,
    limits: Limits,
    token: str = "",
    begun: Callable[[str], None] = lambda _: None,
) -> None:
    """Serve the page until the process is interrupted.

    Parameters
    ----------
    host, port
        Where to listen.
    limits : Limits
        What is taken and kept.
    token : str
        What has to be known, if not a made-up one.
    begun : callable
        Called with the page's address, the token in it, once requests are taken.

    Raises
    ------
    GeohueError
        If the port cannot be had, or starlette or uvicorn is missing.
    """
    try:
        import uvicorn

        from geohue.web.app import make_app
    except ImportError as error:
        raise GeohueError(f'geohue serve needs {error.name}: pip install "geohue[web]"') from error
    door = door_for(host, token)
    with listen(host, port) as listener:
        config = uvicorn.Config(
            make_app(limits, door),
            log_level="warning",
            access_log=False,  # the names of jobs are in the addresses
            server_header=False,
            timeout_graceful_shutdown=_LAST_REQUESTS,
            ws="none",
        )
        begun(address(host, listener.getsockname()[1], door.token))
        uvicorn.Server(config).run(sockets=[listener])


def address(host: str, port: int, token: str) -> str:
    """Return the address of the page.

    Examples
    --------
    >>> address("::1", 80, ""), address("0.0.0.0", 80, "abc")
    ('http://[::1]:80/', 'http://127.0.0.1:80/?token=abc')
    """
    shown = LOOPBACK if host in _ANYWHERE else host
    shown = f"[{shown}]" if ":" in shown else shown
    return f"http://{shown}:{port}/" + (f"?token={token}" if token else "")
