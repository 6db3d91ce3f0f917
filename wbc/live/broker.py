"""Passes requests of the pages on to the loop, and informs the pages of what follows."""

from __future__ import annotations

import contextlib
import time
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from wbc.errors import did_you_mean, short_repr
from wbc.live.config import LiveServerConfig
from wbc.live.controls import Controls, decode
from wbc.motions import Motion
from wbc.runtime.mode import Mode
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.schema import Schema
from wbc.runtime.stream import TickReader
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    KeepVelocityCommand,
    ResetCommand,
    StandCommand,
    VelocityCommand,
)

_MAX_TICKS = 4096  # in one status message
_MAX_UNANSWERED = 1000  # commands whose sender is remembered
_TIMEOUT = 0.5  # s within which the robot stops when the last page that drives is gone
_KEEP_PERIOD = 0.1  # s between two commands that keep the velocity
#: Silence of a page that drives after which it counts as gone, s. Those on this machine
#: close their connection when they end; one may be silent for long because its machine is busy.
_SILENCE, _LOCAL_SILENCE = 0.5, 3.0


class PageClient(Protocol):
    """An open page.

    Attributes:
        local: Whether its browser runs on this machine.
    """

    local: bool

    def send(self, message: dict[str, Any]) -> None:
        """Send it a message; never waits."""


class RequestBroker:
    """Connects any number of pages to the loop.

    Args:
        config: Configuration of the server.
        reader: Reader of the loop's ticks.
    """

    def __init__(self, config: LiveServerConfig, reader: TickReader) -> None:
        capabilities = config.channel.capabilities
        self._client = CommandClient(config.robot, config.channel, "page", capabilities.motions)
        self._client.on_motion_sent = self._on_motion_sent
        self._controls = Controls(capabilities)
        self._pages: dict[PageClient, str] = {}  # with the label of the quantity that each plots
        self._reader = reader
        self._limiter = RateLimiter(config.rate)
        self._schema = reader.schema
        self._series: dict[str, tuple[str, int]] = {}
        self._run = 0
        self._senders: dict[int, PageClient] = {}  # by the number of the command
        self._infeasible = 0  # number of infeasible motions that the pages know of
        self._planning: tuple[Motion, PageClient] | None = None
        self._numbers: dict[str, PageClient] = {}
        #: When the pages that have commanded velocities since standing gave their last sign, s.
        self._drivers: dict[PageClient, float] = {}
        self._kept = 0.0  # s, when the velocity was last kept
        self._velocity = 0  # number of the velocity command in force
        self._opened = 0  # pages so far

    def start_planning(self) -> None:
        """Start to plan motions, first of all with their default parameters."""
        self._client.start_planning()

    def handle(self, message: str | bytes, page: PageClient) -> None:
        """Handle a message of a page; if it is refused, the page receives the reason."""
        try:
            request = decode(message)
            if request.control == "quantity":
                self._select_quantity(request.value, page)
                return
            command = self._controls.command(request)
            if isinstance(command, VelocityCommand):
                command = replace(command, timeout=_TIMEOUT)
            number = self._client.send(command, request.source)
        except CommandRefused as error:
            page.send({"error": str(error)})
            return
        self._senders[number] = page
        if len(self._senders) > _MAX_UNANSWERED:
            del self._senders[next(iter(self._senders))]
        if changes := self._controls.apply(command):
            self._broadcast({"values": changes}, but=page)
        if isinstance(command, VelocityCommand):
            self._velocity = number
            self._drivers[page] = time.monotonic()
        if isinstance(command, (StandCommand, ResetCommand)):
            self._zero_velocity()
        self._announce_planning(page)

    def on_alive(self, page: str) -> None:
        """Note that the page with a number is there."""
        driver = self._numbers.get(page)
        if driver is not None and driver in self._drivers:
            self._drivers[driver] = time.monotonic()

    def _keep_velocity(self, now: float) -> None:
        """Keep the velocity in force while a page that drives is there."""
        ends = [
            seen + (_LOCAL_SILENCE if page.local else _SILENCE)
            for page, seen in self._drivers.items()
        ]
        left = max(ends, default=now) - now
        if left > 0.0 and now >= self._kept + _KEEP_PERIOD:
            self._kept = now
            with contextlib.suppress(CommandRefused):  # a loop that takes none at the moment
                self._client.send(KeepVelocityCommand(self._velocity, min(left, _TIMEOUT)))

    def advance(self) -> None:
        """Forward acknowledgements, and send the status to the pages if it is due."""
        self._keep_velocity(time.monotonic())
        for acknowledgement in self._client.poll():
            self._forward(acknowledgement)
        self._announce_planning(None)
        if len(self._client.infeasible) > self._infeasible:
            self._infeasible = len(self._client.infeasible)
            self._broadcast({"infeasible": self._client.infeasible})
        if not self._limiter.is_due(time.monotonic()):
            return
        if len(ticks := self._reader.take(_MAX_TICKS)):
            self._send_status(ticks)

    def add_page(self, page: PageClient) -> None:
        """Send a new page all controls and values; from now on it receives the status."""
        self._opened += 1
        self._numbers[str(self._opened)] = page
        page.send({"controls": self._controls.describe(), "page": self._opened})
        page.send({"values": self._controls.values, "infeasible": self._client.infeasible})
        page.send({"quantities": list(self._series)})
        self._pages[page] = ""

    def remove_page(self, page: PageClient) -> None:
        """Forget a page that has been closed."""
        self._pages.pop(page, None)
        self._drivers.pop(page, None)
        self._numbers = {number: one for number, one in self._numbers.items() if one is not page}

    def _select_quantity(self, label: Any, page: PageClient) -> None:
        if not isinstance(label, str) or (label and label not in self._series):
            near = did_you_mean(label, self._series) if isinstance(label, str) else ""
            raise CommandRefused(f"no quantity {short_repr(label)}{near}")
        self._pages[page] = label

    def _send_status(self, ticks: np.ndarray) -> None:
        if self._reader.schema is not self._schema:
            self._schema = self._reader.schema
            self._series = series_of(self._schema)
            self._broadcast({"quantities": list(self._series)})
        last, status = ticks[-1], _status(ticks)
        if status["run"] != self._run:
            self._run = status["run"]
            self._zero_velocity()
        for page, label in tuple(self._pages.items()):
            message: dict[str, Any] = {"status": status}
            if label in self._series:
                name, index = self._series[label]
                message["quantity"] = [label, _finite(np.atleast_1d(last[name])[index])]
            page.send(message)

    def _broadcast(self, message: dict[str, Any], but: PageClient | None = None) -> None:
        for page in tuple(self._pages):
            if page is not but:
                page.send(message)

    def _forward(self, acknowledgement: Acknowledgement) -> None:
        """Send the page that sent a command the outcome."""
        number, outcome = acknowledgement.id, acknowledgement.outcome
        if number == self._velocity and outcome is CommandOutcome.ABORTED:
            self._zero_velocity()
            self._broadcast({"error": acknowledgement.reason})
        page = self._senders.get(number)
        if page is None:
            return
        if outcome is not CommandOutcome.ACCEPTED:  # nothing follows
            del self._senders[number]
        page.send({"outcome": outcome.value, "reason": acknowledgement.reason, "id": number})
        if outcome is CommandOutcome.REFUSED:
            page.send({"error": acknowledgement.reason})

    def _on_motion_sent(self, motion: Motion) -> None:
        if not motion.while_walking:
            self._zero_velocity()

    def _zero_velocity(self) -> None:
        self._drivers.clear()
        self._broadcast({"values": self._controls.zero_velocity()})

    def _announce_planning(self, page: PageClient | None) -> None:
        """Inform the page whose motion is being planned when that begins and ends."""
        motion = self._client.planning
        if self._planning is not None and self._planning[0] is not motion:
            self._planning[1].send({"planning": None})
            self._planning = None
        if self._planning is None and motion is not None and page is not None:
            self._planning = (motion, page)
            page.send({"planning": motion.name})


def series_of(schema: Schema) -> dict[str, tuple[str, int]]:
    """Return the column and the index in it of every number of a tick, by its label."""
    return {
        column.label(i): (column.name, i) for column in schema.columns for i in range(column.size)
    }


def _status(ticks: np.ndarray) -> dict[str, Any]:
    """Return the last tick's status, with the largest DCM error and tick time of all ticks."""
    last = ticks[-1]
    running = ticks[ticks["mode"] == Mode.RUNNING]
    times = running["estimator_time"] + running["controller_time"]
    return {
        "stamp": round(time.monotonic(), 3),
        "time": round(float(last["time"]), 4),
        "mode": Mode(int(last["mode"])).name.lower(),
        "dcm_error": _largest(running["dcm_error"]),
        "tick_time": _largest(times),
        "velocity": [_finite(x) for x in last["velocity_command"]],
        "playing": int(last["motion_playing"]),
        "pushes": int(last["pushes_decided"]),
        "survived": int(last["pushes_survived"]),
        "run": int(last["run"]),
    }


def _largest(values: np.ndarray) -> float | None:
    return _finite(np.max(values, initial=0.0, where=np.isfinite(values)))


def _finite(value: float) -> float | None:
    return round(float(value), 6) if np.isfinite(value) else None
