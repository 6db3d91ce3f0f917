"""Passes requests of the pages on to the loop, and informs the pages of what follows."""

from __future__ import annotations

import asyncio
import contextlib
import time
from dataclasses import replace
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from wbc.errors import WbcError, did_you_mean, short_repr
from wbc.live.config import LiveServerConfig
from wbc.live.controls import Controls, decode
from wbc.live.explainer import TickExplainer
from wbc.live.hand_handles import HandHandles
from wbc.live.history import History
from wbc.live.run_events import RunEvents
from wbc.live.saving import FileKind, SavedFiles, Stretch
from wbc.live.signals import signal_limits, signal_places
from wbc.live.uploads import Uploads
from wbc.live.walk_to import WalkTo
from wbc.motions import Motion
from wbc.runtime.controller_inputs import NAME
from wbc.runtime.mode import Mode
from wbc.runtime.rate_limiter import RateLimiter
from wbc.runtime.stream import TickReader
from wbc.teleop import (
    Acknowledgement,
    CommandClient,
    CommandOutcome,
    CommandRefused,
    FrameTaskCommand,
    KeepVelocityCommand,
    ResetCommand,
    StandCommand,
    StartSessionCommand,
    VelocityCommand,
)
from wbc.teleop.number_checks import check_number

_MAX_TICKS = 4096  # in one status message
_MAX_SIGNALS = 64  # of a page
_LONGEST = 1e9  # s
_POINTS = 1500  # of the older and of the newer half of a signal's past
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
        self._pages: dict[PageClient, list[str]] = {}  # with the signals that each draws
        self._reader = reader
        self._limiter = RateLimiter(config.rate)
        self._explainer: TickExplainer[PageClient] = TickExplainer(config.robot)
        self._last: Any = None  # record of the last tick
        self._schema = reader.schema
        self._places: dict[str, int] = {}  # of the signals
        self._sent = 0  # number of the samples that the pages have received
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
            match request.control:
                case "why":
                    self._explain(request.value, page)
                    return
                case "signals":
                    self._select_signals(request.value, page)
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
        if isinstance(command, FrameTaskCommand):
            self._controls.apply_frame_task(command)
            self._announce_frame_tasks()
        if isinstance(command, VelocityCommand):
            self._velocity = number
            self._drivers[page] = time.monotonic()
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
        command = VelocityCommand(*velocity, timeout=_TIMEOUT)
        try:
            self._velocity = self._client.send(command, "page")
        except CommandRefused as error:
            page.send({"error": str(error)})
            self._end_walk_to()
            return
        self._drivers.setdefault(page, time.monotonic())
        self._broadcast({"values": self._controls.apply(command)})
        if self._walk_to.target is None:
            self._end_walk_to()

    def _end_walk_to(self) -> None:
        if self._walker is not None:
            self._walker, self._walk_to.target = None, None
            self._broadcast({"walk_to": None})

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
        self._offer_signals(page)
        page.send({"events": self._events.all, "files": self._uploads.names})
        if self._config.notice:
            page.send({"error": self._config.notice})
        self._pages[page] = []

    def announce_files(self) -> None:
        """Send the pages the names of the files that they may name."""
        self._broadcast({"files": self._uploads.names})

    def remove_page(self, page: PageClient) -> None:
        """Forget a page that has been closed."""
        self._pages.pop(page, None)
        self._drivers.pop(page, None)
        if page is self._walker:
            self._end_walk_to()
        self._numbers = {number: one for number, one in self._numbers.items() if one is not page}

    def _offer_signals(self, page: PageClient) -> None:
        limits = signal_limits(self._schema, self._config.robot, self._config.dt)
        page.send({"signals": list(self._places), "limits": limits})

    def _select_signals(self, labels: Any, page: PageClient) -> None:
        """Send a page the past of the signals that it draws; from now on it receives the rest."""
        if not isinstance(labels, list) or not all(isinstance(label, str) for label in labels):
            raise CommandRefused(f"signals are {short_repr(labels)}; they are a list of names")
        if len(labels) > _MAX_SIGNALS:
            raise CommandRefused(f"a page draws at most {_MAX_SIGNALS} signals")
        for label in labels:
            if label not in self._places:
                near = did_you_mean(label, self._places)
                raise CommandRefused(f"no signal {short_repr(label)}{near}")
        self._pages[page] = labels
        if labels:
            page.send({"past": self._series(labels, 0)})

    def _series(self, labels: list[str], since: int) -> dict[str, Any]:
        """Return signals over time, from the sample of a number on, as JSON."""
        places = [self._places[label] for label in labels]
        found = self._history.series(places, since, _POINTS)
        values = {
            label: [_numbers(one.low), _numbers(one.high)]
            for label, one in zip(labels, found, strict=True)
        }
        return {"time": np.round(found[0].time, 4).tolist() if found else [], "values": values}

    def _save(self, value: Any, page: PageClient) -> None:
        """Write a stretch of the session to a file, and send the page its address."""
        kind, start, end = _stretch_of(value)
        records, times = self._history.stretch(start, end)
        if not len(records):
            raise CommandRefused(f"nothing is kept of {start:.1f} to {end:.1f} s")
        events = self._events.between(float(times[0]), float(times[-1]))
        config = self._config
        stretch = Stretch(
            config.robot, config.boxes, self._schema, records, times,
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
        if self._last is None or NAME not in self._schema.by_name:
            raise CommandRefused(
                "ticks can be explained while they are logged: start  wbc live --log FILE"
            )
        record = self._last
        if value is not None and len(self._history):
            record = self._history.record_at(check_number("why", value, 0.0, _LONGEST, "s"))
        self._explainer.request(record, page)

    def _send_status(self, ticks: np.ndarray) -> None:
        self._last = ticks[-1]
        if self._reader.schema is not self._schema:
            self._schema = self._reader.schema
            self._places = signal_places(self._schema)
            for page in tuple(self._pages):
                self._pages[page] = [x for x in self._pages[page] if x in self._places]
                self._offer_signals(page)
        status = _status(ticks)
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
        since, self._sent = self._sent, self._history.count
        for page, labels in tuple(self._pages.items()):
            message: dict[str, Any] = {"status": status}
            if labels and since < self._sent:
                message["points"] = self._series(labels, since)
            page.send(message)

    def _announce_frame_tasks(self) -> None:
        self._broadcast({"frame_tasks": self._controls.describe_frame_tasks()})

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


def _numbers(values: np.ndarray) -> list[float | None]:
    """Return numbers for JSON, to seven digits; None for unknown ones."""
    return [float(f"{x:.7g}") if np.isfinite(x) else None for x in values.tolist()]


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
        "heading": _finite(last["heading"]),
        "playing": int(last["motion_playing"]),
        "pushes": int(last["pushes_decided"]),
        "survived": int(last["pushes_survived"]),
        "run": int(last["run"]),
    }


def _largest(values: np.ndarray) -> float | None:
    return _finite(np.max(values, initial=0.0, where=np.isfinite(values)))


def _finite(value: float) -> float | None:
    return round(float(value), 6) if np.isfinite(value) else None
