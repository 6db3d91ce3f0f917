"""Runs a robot in physics that commands drive, falls and resets included."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from wbc.errors import PhysicsDiverged
from wbc.runtime import loop
from wbc.runtime.event import COMMAND, RESET, RunEvent, tell
from wbc.runtime.mode import Mode
from wbc.runtime.protocols import Observer, StateEstimator, StreamObserver
from wbc.runtime.real_time import RealTime, real_time_thread
from wbc.runtime.report import Report
from wbc.runtime.schema import Quantity
from wbc.runtime.statistics import Progress
from wbc.teleop.acknowledgement import Acknowledgement
from wbc.teleop.command_handler import CommandHandler
from wbc.teleop.commands import SentCommand, command_json, command_name


class TeleopClient(Observer, StreamObserver, Protocol):
    """Something outside the loop that shows the robot and sends commands, e.g. the live page.

    While there are no ticks, its stream repeats the last one with the mode of the loop.
    """

    @property
    def reset_hint(self) -> str:
        """The instruction for a person to reset the robot there."""


def run(
    handler: CommandHandler,
    duration: float,
    *,
    clients: Sequence[TeleopClient] = (),
    estimator: StateEstimator | None = None,
    observers: Sequence[Observer] = (),
    quantities: Sequence[Quantity] = (),
    real_time: bool | RealTime = True,
    before_tick: Callable[[float], None] = lambda _: None,
    stop: Callable[[], bool] = lambda: False,
    progress: Callable[[Progress], None] | None = None,
    message: Callable[[str], None] = lambda _: None,
) -> Report | None:
    """Run until the duration is over; after a fall wait until a command resets the robot.

    Args:
        handler: takes the commands; it knows controller and plant, which is a simulator.
        duration: s of plant time; time after a fall counts by the wall clock.
        clients: see every tick, and the mode of the loop while there is none.
        estimator: see `wbc.run`.
        observers: beside the clients, see `wbc.run`; they see every run between two resets.
        quantities: see `wbc.run`.
        real_time: run by the wall clock, see `wbc.run`; a handler that owns its clock does so in
            any case.
        before_tick: called with the plant's time before the commands are applied; a script submits
            its commands here.
        stop: asked several times per second whether to end the run.
        progress: see `wbc.run`.
        message: called with a line of text when the robot falls or is reset, or stops because the
            sender of its velocity has fallen silent.

    Returns:
        The report of the last run between two resets; None when the physics diverged in its first
        tick. Without clients, which could reset the robot, the run ends with its fall. It also
        ends when the handler's `next_session` is set.
    """

    def on_progress(now: Progress) -> None:
        if progress is not None:
            progress(now)
        if stop():
            raise loop.StopRun("stopped")

    def on_idle(mode: Mode) -> None:
        stream = next((client.stream for client in clients), None)
        if stream is not None:
            stream.repeat(mode, time.time(), handler.status())

    def on_acknowledgement(sent: SentCommand, acknowledgement: Acknowledgement) -> None:
        tell((*clients, *observers), _command_event(sent, acknowledgement))

    def ends() -> bool:
        return stop() or handler.next_session is not None

    handler.stop, handler.on_idle, handler.on_timeout = stop, on_idle, message
    left, resets, told = duration, 0, 0

    def on_tick(now: float) -> None:
        nonlocal told
        if told < resets:
            told = resets
            tell((*clients, *observers), RunEvent(now, RESET))
        before_tick(now)
        handler.before_tick(now)

    with contextlib.ExitStack() as stack:
        handler.add_observer(on_acknowledgement)
        stack.callback(handler.remove_observer, on_acknowledgement)
        if handler.owns_clock:
            wanted = real_time if isinstance(real_time, RealTime) else RealTime()
            message(stack.enter_context(real_time_thread(wanted)).describe())
        while True:
            handler.plant.reset()
            report: Report | None = None
            handler.begin()
            try:
                report = loop.run(
                    handler.player,
                    handler.plant,
                    left,
                    estimator=estimator,
                    observers=(*clients, *observers),
                    quantities=(*quantities, *handler.quantities),
                    real_time=False if handler.owns_clock else real_time,
                    on_falling=lambda text: message(f"the robot is {text}"),
                    before_tick=on_tick,
                    progress=on_progress,
                )
                reason = f"fell: {report.fell_why}" if report.fell_at_s is not None else ""
                if report.diverged:
                    reason = report.fell_why
            except PhysicsDiverged as error:  # in the first tick, before there is a report
                reason = str(error)
            left -= handler.plant.time
            if not handler.reset_wanted:
                if not reason or not clients:
                    return report
                hints = " or ".join(client.reset_hint for client in clients)
                message(f"{reason}; to reset it: {hints}")
                left -= _wait_for_reset(handler, left, ends)
            if ends() or left <= handler.plant.dt:
                return report
            message("reset")
            resets += 1


def _command_event(sent: SentCommand, acknowledgement: Acknowledgement) -> RunEvent:
    return RunEvent(
        acknowledgement.time,
        COMMAND,
        sent.source,
        sent.id,
        command_name(sent.command),
        command_json(sent.command),
        acknowledgement.outcome.value,
        acknowledgement.reason,
    )


def _wait_for_reset(handler: CommandHandler, longest: float, ends: Callable[[], bool]) -> float:
    """Wait until a reset is wanted; return how long that took, s."""
    start = time.monotonic()
    while not (handler.reset_wanted or ends()):
        handler.idle_after_fall()
        if time.monotonic() - start >= longest:
            break
    return time.monotonic() - start
