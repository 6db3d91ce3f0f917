"""Passes requests of the pages on to the loop, and tells the pages what becomes of them."""

from __future__ import annotations

import json
import time
from typing import Any, Protocol

import numpy as np

from wbc.live.config import LiveServerConfig
from wbc.live.controls import Controls
from wbc.live.series import SeriesSource
from wbc.motions import Motion
from wbc.runtime.mode import Mode
from wbc.runtime.stream import TickReader
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    ResetCommand,
    StandCommand,
)

_MAX_TICKS = 4096  # in one summary
_MAX_UNANSWERED = 1000  # commands of which the sender is remembered


class PageClient(Protocol):
    """An open page."""

    def send(self, text: str) -> None:
        """Send it a text; never waits."""


class RequestBroker:
    """Connects any number of pages to the loop.

    Args:
        config: of the server.
        reader: of the loop's ticks.

    Attributes:
        controls: what the pages offer.
        pages: those that are open.
        series: quantities that the pages plot.
    """

    def __init__(self, config: LiveServerConfig, reader: TickReader) -> None:
        capabilities = config.channel.capabilities
        self._client = CommandClient(config.robot, config.channel, "page", capabilities.motions)
        self._client.on_motion_sent = self._on_motion_sent
        self.controls = Controls(capabilities)
        self.pages: set[PageClient] = set()
        self._reader = reader
        self.series = SeriesSource()
        self._run = 0
        self._senders: dict[int, PageClient] = {}  # by the number of the command
        self._infeasible = 0  # motions that the pages have been told of
        self._planning: tuple[Motion, PageClient] | None = None

    def start_planning(self) -> None:
        """Start the planning of motions, first of all with their default parameters."""
        self._client.start_planning()

    def handle(self, message: str | bytes, page: PageClient) -> None:
        """Take a message of a page. If it is refused, the page gets the reason."""
        try:
            command, source = self.controls.parse(message)
            number = self._client.send(command, source)
        except CommandRefused as error:
            _send(page, {"error": str(error)})
            return
        self._senders[number] = page
        if len(self._senders) > _MAX_UNANSWERED:
            del self._senders[next(iter(self._senders))]
        changes = self.controls.note(command)
        if changes:
            self.broadcast({"values": changes}, but=page)
        if isinstance(command, (StandCommand, ResetCommand)):
            self._zero_velocity()
        self._tell_planning(page)

    def advance(self) -> None:
        """Read acknowledgements and ticks, and send the news to the pages."""
        for acknowledgement in self._client.poll():
            self._forward(acknowledgement)
        self._tell_planning(None)
        if len(self._client.infeasible) > self._infeasible:
            self._infeasible = len(self._client.infeasible)
            self.broadcast({"infeasible": self._client.infeasible})
        ticks = self._reader.take(_MAX_TICKS)
        if not len(ticks):
            return
        self.series.attach(self._reader.schema)
        self.series.advance(ticks)
        run = int(ticks["run"][-1])
        if run != self._run:
            self._run = run
            self._zero_velocity()
        self.broadcast({"status": _summary(ticks)})

    def welcome(self, page: PageClient) -> None:
        """Tell a new page what is offered and all values, and what happens from now on."""
        _send(page, {"controls": self.controls.describe()})
        _send(page, {"values": self.controls.values, "infeasible": self._client.infeasible})
        self.pages.add(page)

    def broadcast(self, news: dict[str, Any], but: PageClient | None = None) -> None:
        """Send something to all pages but one."""
        text = json.dumps(news, separators=(",", ":"))
        for page in tuple(self.pages):
            if page is not but:
                page.send(text)

    def _forward(self, acknowledgement: Acknowledgement) -> None:
        """Tell the page that sent a command what became of it."""
        number, outcome = acknowledgement.id, acknowledgement.outcome
        page = self._senders.get(number)
        if page is None:
            return
        if outcome is not CommandOutcome.ACCEPTED:  # nothing follows
            del self._senders[number]
        _send(page, {"outcome": outcome.value, "reason": acknowledgement.reason, "id": number})
        if outcome is CommandOutcome.REFUSED:
            _send(page, {"error": acknowledgement.reason})

    def _on_motion_sent(self, motion: Motion) -> None:
        if not motion.while_walking:
            self._zero_velocity()

    def _zero_velocity(self) -> None:
        self.broadcast({"values": self.controls.zero_velocity()})

    def _tell_planning(self, page: PageClient | None) -> None:
        """Tell the page whose motion is being planned, when that begins and ends."""
        motion = self._client.planning
        if self._planning is not None and self._planning[0] is not motion:
            _send(self._planning[1], {"planning": None})
            self._planning = None
        if self._planning is None and motion is not None and page is not None:
            self._planning = (motion, page)
            _send(page, {"planning": motion.name})


def _send(page: PageClient, news: dict[str, Any]) -> None:
    page.send(json.dumps(news))


def _summary(ticks: np.ndarray) -> dict[str, Any]:
    """Return the last tick's status, with the largest DCM error and tick time of all ticks."""
    last = ticks[-1]
    running = ticks[ticks["mode"] == Mode.RUNNING]
    times = running["estimator_time"] + running["controller_time"]
    return {
        "stamp": round(time.monotonic(), 3),
        "time": round(float(last["time"]), 4),
        "mode": Mode(int(last["mode"])).name.lower(),
        "dcm_error": _rounded(_largest(running["dcm_error"])),
        "tick_time": _rounded(_largest(times)),
        "velocity": [_rounded(x) for x in last["velocity_command"].tolist()],
        "playing": int(last["motion_playing"]),
        "pushes": int(last["pushes_decided"]),
        "survived": int(last["pushes_survived"]),
        "run": int(last["run"]),
    }


def _largest(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(known.max()) if known.size else 0.0


def _rounded(value: float) -> float | None:
    return round(value, 6) if abs(value) < float("inf") else None
