"""The address that the page is served at, and the host names by which it may be requested."""

from __future__ import annotations

import os
import pwd
import re
import socket

from wbc.live.errors import LiveError
from wbc.view.web import HOST, LOOPBACK

_ANY = ("", "0.0.0.0", "::")
_FIRST_USER, _NOBODY = 1000, 65534  # user ids of people


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
        return _own_address()
    return f"[{host}]" if ":" in host else host


def is_local(host: str) -> bool:
    """Return whether only this machine reaches an address."""
    return host == "localhost" or host == "::1" or host.startswith("127.")


def needs_token(host: str) -> bool:
    """Return whether others than the user may reach an address: by network, or on this machine."""
    return not is_local(host) or _has_other_users()


def _own_address() -> str:
    """Return the address by which others in the network reach this machine.

    A host name is none: others may not know it.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))  # sends nothing; selects the interface
        except OSError:
            return HOST
        return str(probe.getsockname()[0])


def _has_other_users() -> bool:
    own = os.getuid()
    return any(
        _FIRST_USER <= user.pw_uid < _NOBODY
        and user.pw_uid != own
        and not user.pw_shell.endswith(("/nologin", "/false"))
        for user in pwd.getpwall()
    )
