"""Keeps the commanded velocity while a page that drives is there (a dead man's switch)."""

from __future__ import annotations

import contextlib
import time
from typing import Protocol

from wbc.teleop import CommandClient, CommandRefused, KeepVelocityCommand

TIMEOUT = 0.5  # s within which the robot stops when the last page that drives is gone
_PERIOD = 0.1  # s between two commands that keep the velocity
#: Silence of a page that drives after which it counts as gone, s. Those on this machine
#: close their connection when they end; one may be silent for long because its machine is busy.
_SILENCE, _LOCAL_SILENCE = TIMEOUT, 3.0


class DrivingPage(Protocol):
    """A page that may drive.

    Attributes:
        local: Whether its browser runs on this machine.
    """

    local: bool


class DrivingPages:
    """The pages that have commanded velocities since the robot stood.

    Args:
        client: Sends the commands.
    """

    def __init__(self, client: CommandClient) -> None:
        self._client = client
        self._seen: dict[DrivingPage, float] = {}  # when each gave its last sign, s
        self._kept = 0.0  # s, when the velocity was last kept
        self._velocity = 0  # number of the velocity command in force

    def on_velocity(self, page: DrivingPage, number: int) -> None:
        """Note that a page has sent the velocity command of a number."""
        self._velocity = number
        self._seen[page] = time.monotonic()

    def on_walk_to(self, page: DrivingPage, number: int) -> None:
        """Note a velocity command on the way to a target of a page, which is no sign of it."""
        self._velocity = number
        self._seen.setdefault(page, time.monotonic())

    def on_alive(self, page: DrivingPage) -> None:
        """Note a sign of a page."""
        if page in self._seen:
            self._seen[page] = time.monotonic()

    def is_in_force(self, number: int) -> bool:
        """Return whether a number is that of the velocity command in force."""
        return number == self._velocity

    def remove(self, page: DrivingPage) -> None:
        """Forget a page that has been closed; with the last one the velocity ends at once."""
        if self._seen.pop(page, None) is not None and not self._seen:
            self._keep(0.0)

    def clear(self) -> None:
        """Forget all pages: the robot stands."""
        self._seen.clear()

    def advance(self, now: float) -> None:
        """Keep the velocity in force while a page is there; call it often.

        Args:
            now: Time by `time.monotonic`, s.
        """
        ends = [
            seen + (_LOCAL_SILENCE if page.local else _SILENCE) for page, seen in self._seen.items()
        ]
        left = max(ends, default=now) - now
        if left > 0.0 and now >= self._kept + _PERIOD:
            self._kept = now
            self._keep(min(left, TIMEOUT))

    def _keep(self, timeout: float) -> None:
        with contextlib.suppress(CommandRefused):  # a loop that takes none at the moment
            self._client.send(KeepVelocityCommand(self._velocity, timeout))
