"""Under which names a server is known, and what has to be known to enter."""

from __future__ import annotations

import ipaddress
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Door:
    """Who is let in.

    Attributes
    ----------
    hosts : frozenset of str
        Names without a port that a request may be addressed to. A page elsewhere that has its own
        name resolved to this machine (DNS rebinding) is addressed to another one.
    any_address : bool
        Whether it may also be addressed to any numeric address: no name was resolved then.
    token : str
        What has to be known; empty where only this machine can ask.
    """

    hosts: frozenset[str]
    any_address: bool = False
    token: str = ""

    def knows(self, host: str) -> bool:
        """Whether a request may be addressed to this ``Host``.

        Examples
        --------
        >>> door = Door(frozenset({"127.0.0.1", "localhost"}))
        >>> door.knows("localhost:8484"), door.knows("evil.example:8484"), door.knows("")
        (True, False, False)
        """
        name = _without_port(host).lower()
        return name in self.hosts or (self.any_address and _is_address(name))


def _without_port(host: str) -> str:
    if host.startswith("["):
        return host[1:].split("]")[0]
    return host.rsplit(":", 1)[0] if host.count(":") == 1 else host


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
