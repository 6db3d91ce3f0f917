"""The address that the page is served at, and the host names by which it may be requested."""

from __future__ import annotations

import re
import socket

from wbc.live.errors import LiveError
from wbc.view.web import HOST, LOOPBACK

_ANY = ("", "0.0.0.0", "::")


def check_host(host: str) -> None:
    """Refuse an address that no server can listen on.

    Raises:
        LiveError: the name is unknown, or the address belongs to another machine.
    """
    if host in _ANY:
        return
    cure = f"give one of this machine's, {HOST} for this machine only, or 0.0.0.0 for all"
    try:
        family, kind, _, _, address = socket.getaddrinfo(host, 0, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError):
        raise LiveError(f"'{host}' is neither an address nor a known name: {cure}") from None
    with socket.socket(family, kind) as test:
        try:
            test.bind(address)
        except OSError:
            where = f" ({address[0]})" if address[0] != host else ""
            text = f"'{host}'{where} is not an address of this machine: {cure}"
            raise LiveError(text) from None


def allowed_hosts(host: str) -> str:
    """Return a regular expression of the host names by which the page may be requested.

    A name that others can direct to this machine (DNS rebinding) is never among them.
    """
    if host in (HOST, "localhost"):
        return LOOPBACK
    if host in _ANY:
        own = re.escape(socket.gethostname())
        return rf"(localhost|{own}|[0-9.]+|\[?[0-9a-fA-F:.]+\]?)"
    return rf"({LOOPBACK}|\[?{re.escape(host)}\]?)"


def url_host(host: str) -> str:
    """Return the host part of the page's address."""
    if host in _ANY:
        return socket.gethostname()
    return f"[{host}]" if ":" in host else host
