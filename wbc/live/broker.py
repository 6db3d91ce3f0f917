"""Passes requests of the pages on to the loop, and informs the pages of what follows."""

from __future__ import annotations

import asyncio
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from wbc.errors import WbcError, short_repr
from wbc.live.config import LiveServerConfig
from wbc.live.controls import Controls, decode
from wbc.live.driving_pages import TIMEOUT, DrivingPage, DrivingPages
from wbc.live.explainer import TickExplainer
from wbc.live.hand_handles import HandHandles
from wbc.live.history import History
from wbc.live.run_events import RunEvents
from wbc.live.saving import FileKind, SavedFiles, Stretch
from wbc.live.signal_streams import SignalStreams
from wbc.live.tick_status import tick_status
from wbc.live.uploads import Uploads
from wbc.live.walk_to import WalkTo
from wbc.motions import Motion
from wbc.runtime.mode import Mode
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.stream import TickReader
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    FrameTaskCommand,
    MotionCommand,
    ResetCommand,
    StandCommand,
    StartSessionCommand,
    TeleopCommand,
    VelocityCommand,
)
from wbc.teleop.number_checks import check_number

_MAX_TICKS = 4096  # in one status message
_LONGEST = 1e9  # s
_LASTING = (MotionCommand, ResetCommand, VelocityCommand)  # another outcome follows "accepted"


class PageClient(DrivingPage, Protocol):
    """An open page."""

    def send(self, message: dict[str, Any]) -> None:
        """Send it a message; never waits."""

    def send_status(self, message: dict[str, Any]) -> None:
        """Send it a message that may be dropped if it reads too slowly."""


class RequestBroker:
    """Connects any number of pages to the loop.

    Args:
        config: Configuration of the server.
        reader: Reader of the loop's ticks.
        history: Keeps the ticks of the last minutes.
        files: Writes them to files.
        uploads: The files that pages have sent.
    """

    def __init__(
        self,
        config: LiveServerConfig,
        reader: TickReader,
        history: History,
        files: SavedFiles,
        uploads: Uploads,
    ) -> None:
        capabilities = config.channel.capabilities
        self._config, self._history, self._files = config, history, files
        self._uploads = uploads
        self._events = RunEvents(config.events, history)
        self._walk_to = WalkTo(config.robot, capabilities.max_velocity)
        self._hand_handles = HandHandles(config.robot)
        self._walker: PageClient | None = None  # the page that has set the target
        self._saving: set[asyncio.Task[None]] = set()
        self._client = CommandClient(config.robot, config.channel, "page", capabilities.motions)
        self._client.on_motion_sent = self._on_motion_sent
        self._controls = Controls(capabilities, uploads)
        self._pages: list[PageClient] = []
        self._driving = DrivingPages(self._client)
        self._reader = reader
        self._limiter = RateLimiter(config.rate)
        self._explainer: TickExplainer[PageClient] = TickExplainer(config.robot)
        self._last: Any = None  # record of the last tick
        self._signals: SignalStreams[PageClient] = SignalStreams(config.robot, config.dt, history)
        self._run = 0
        #: By the number of the command, until nothing more follows.
        self._senders: dict[int, tuple[PageClient, TeleopCommand]] = {}
        self._accepted_velocity = 0  # number of the last one
        self._infeasible = 0  # number of infeasible motions that the pages know of
        self._planning: tuple[Motion, PageClient] | None = None
        self._numbers: dict[str, PageClient] = {}
        self._opened = 0  # pages so far

    def start_planning(self) -> None:
        """Start to plan motions, first of all with their default parameters."""
        self._client.start_planning()

    def handle(self, message: str | bytes, page: PageClient) -> None:
        """Handle a message of a page; if it is refused, the page receives the reason."""
        try:
            request = decode(message)
            match request.control:
                case "why":
                    self._explain(request.value, page)
                    return
                case "signals":
                    if past := self._signals.choose(page, request.value):
                        page.send(past)
                    return
                case "save":
                    self._save(request.value, page)
                    return
                case "walk_to":
                    self._walk_to.start(request.value)
                    self._walker = page
                    self._broadcast({"walk_to": self._walk_to.target})
                    return
            command = self._controls.command(request)
            if isinstance(command, VelocityCommand):
                command = replace(command, timeout=TIMEOUT)
            number = self._client.send(command, request.source)
        except CommandRefused as error:
            page.send({"error": str(error)})
            return
        self._senders[number] = page, command
        if changes := self._controls.apply(command):
            self._broadcast({"values": changes}, but=page)
        if isinstance(command, FrameTaskCommand):
            self._controls.apply_frame_task(command)
            self._announce_frame_tasks()
        if isinstance(command, VelocityCommand):
            self._driving.on_velocity(page, number)
            self._end_walk_to()
        if isinstance(command, (StandCommand, ResetCommand)):
            self._zero_velocity()
        if isinstance(command, StartSessionCommand):
            self._broadcast({"starting": f"{Path(command.robot).stem}, {command.terrain}"})
        self._announce_planning(page)

    def _advance_walk_to(self, tick: np.void) -> None:
        """Command the next velocity on the way to a target, while its page is there."""
        page = self._walker
        if self._walk_to.target is None or page is None:
            return
        velocity = self._walk_to.velocity(tick)
        if velocity is None:
            return
        command = VelocityCommand(*velocity, timeout=TIMEOUT)
        try:
            number = self._client.send(command, "page")
        except CommandRefused as error:
            page.send({"error": str(error)})
            self._end_walk_to()
            return
        self._driving.on_walk_to(page, number)
        self._broadcast({"values": self._controls.apply(command)})
        if self._walk_to.target is None:
            self._end_walk_to()

    def _end_walk_to(self) -> None:
        if self._walker is not None:
            self._walker, self._walk_to.target = None, None
            self._broadcast({"walk_to": None})

    def on_alive(self, page: str) -> None:
        """Note that the page with a number is there."""
        if page in self._numbers:
            self._driving.on_alive(self._numbers[page])

    def advance(self) -> None:
        """Forward acknowledgements, and send the status to the pages if it is due."""
        self._driving.advance(time.monotonic())
        for page, why in self._explainer.answers():
            page.send({"why": why})
        for acknowledgement in self._client.poll():
            self._forward(acknowledgement)
        self._announce_planning(None)
        if len(self._client.infeasible) > self._infeasible:
            self._infeasible = len(self._client.infeasible)
            self._broadcast({"infeasible": self._client.infeasible})
        if not self._limiter.is_due(time.monotonic()):
            return
        ticks = self._reader.take(_MAX_TICKS)
        if len(ticks):
            self._history.add(ticks, self._reader.schema)
        if new := self._events.take():
            self._broadcast({"events": new})
        if len(ticks):
            self._send_status(ticks)
            if ticks[-1]["mode"] == Mode.RUNNING:
                self._advance_walk_to(ticks[-1])

    def add_page(self, page: PageClient) -> None:
        """Send a new page all controls and values; from now on it receives the status."""
        self._opened += 1
        self._numbers[str(self._opened)] = page
        page.send({"controls": self._controls.describe(), "page": self._opened})
        page.send({"values": self._controls.values, "infeasible": self._client.infeasible})
        page.send({"frame_tasks": self._controls.describe_frame_tasks()})
        page.send(self._signals.offer())
        page.send({"events": self._events.all, "files": self._uploads.names})
        if self._config.notice:
            page.send({"error": self._config.notice})
        self._pages.append(page)

    def announce_files(self) -> None:
        """Send the pages the names of the files that they may name."""
        self._broadcast({"files": self._uploads.names})

    def remove_page(self, page: PageClient) -> None:
        """Forget a page that has been closed."""
        if page in self._pages:
            self._pages.remove(page)
        self._signals.remove(page)
        self._driving.remove(page)
        self._senders = {n: sent for n, sent in self._senders.items() if sent[0] is not page}
        if page is self._walker:
            self._end_walk_to()
        self._numbers = {number: one for number, one in self._numbers.items() if one is not page}

    def _save(self, value: Any, page: PageClient) -> None:
        """Write a stretch of the session to a file, and send the page its address."""
        kind, start, end = _stretch_of(value)
        records, times = self._history.stretch(start, end)
        if not len(records):
            raise CommandRefused(f"nothing is kept of {start:.1f} to {end:.1f} s")
        events = self._events.between(float(times[0]), float(times[-1]))
        config = self._config
        stretch = Stretch(
            config.robot, config.boxes, self._signals.schema, records, times,
            tuple(one for _, one in events), tuple(time for time, _ in events),
        )  # fmt: skip

        async def save() -> None:
            page.send({"saving": kind})
            try:
                page.send({"saved": await self._files.save(kind, stretch)})
            except WbcError as error:
                page.send({"saved": "", "error": str(error)})

        task = asyncio.get_running_loop().create_task(save())
        self._saving.add(task)  # a task that nobody holds may be collected
        task.add_done_callback(self._saving.discard)

    def _explain(self, value: Any, page: PageClient) -> None:
        """Explain the present tick (None) or the sample at a session time, s."""
        if self._last is None:
            raise CommandRefused("there is no tick yet to be explained")
        record = self._last
        if value is not None and len(self._history):
            record = self._history.record_at(check_number("why", value, 0.0, _LONGEST, "s"))
        self._explainer.request(record, page)

    def _send_status(self, ticks: np.ndarray) -> None:
        self._last = ticks[-1]
        if self._reader.schema is not self._signals.schema:
            self._signals.change_schema(self._reader.schema)
            self._broadcast(self._signals.offer())
        status = tick_status(ticks)
        status |= {
            "session": round(self._history.end, 4),
            "session_start": round(self._history.start, 4),
            "fall": self._events.fall if status["mode"] == "fallen" else "",
            "hands": self._hand_handles.describe(ticks[-1]),
        }
        if status["run"] != self._run:
            self._run = status["run"]
            self._zero_velocity()
            self._controls.frame_tasks.clear()
            self._announce_frame_tasks()
        points = self._signals.new_points()
        for page in tuple(self._pages):
            page.send_status({"status": status, **points.get(page, {})})

    def _announce_frame_tasks(self) -> None:
        self._broadcast({"frame_tasks": self._controls.describe_frame_tasks()})

    def _broadcast(self, message: dict[str, Any], but: PageClient | None = None) -> None:
        for page in tuple(self._pages):
            if page is not but:
                page.send(message)

    def _forward(self, acknowledgement: Acknowledgement) -> None:
        """Send the page that sent a command the outcome."""
        number, outcome = acknowledgement.id, acknowledgement.outcome
        if self._driving.is_in_force(number) and outcome is CommandOutcome.ABORTED:
            self._zero_velocity()
            self._broadcast({"error": acknowledgement.reason})
        if number not in self._senders:
            return
        page, command = self._senders[number]
        if outcome is not CommandOutcome.ACCEPTED or not isinstance(command, _LASTING):
            del self._senders[number]
        elif isinstance(command, VelocityCommand):
            self._senders.pop(self._accepted_velocity, None)
            self._accepted_velocity = number
        page.send({"outcome": outcome.value, "reason": acknowledgement.reason, "id": number})
        if outcome is CommandOutcome.REFUSED:
            page.send({"error": acknowledgement.reason})

    def _on_motion_sent(self, motion: Motion) -> None:
        if not motion.while_walking:
            self._zero_velocity()

    def _zero_velocity(self) -> None:
        self._driving.clear()
        self._end_walk_to()
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


def _stretch_of(value: Any) -> tuple[FileKind, float, float]:
    """Return the kind, start and end, s, of a stretch that a page wants to save.

    Raises:
        CommandRefused: The request has another form.
    """
    form = '{"as": "log" or "film", "from": seconds, "to": seconds}'
    if not isinstance(value, dict) or value.get("as") not in ("log", "film"):
        raise CommandRefused(f"save is {short_repr(value)}; it is {form}")
    start, end = (
        check_number(name, value.get(name), -_LONGEST, _LONGEST, "s") for name in ("from", "to")
    )
    return value["as"], start, end
