"""Collects the commands of all senders, and tells each sender what became of its commands."""

from __future__ import annotations

import itertools
import time
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from wbc.robot import Robot
from wbc.teleop.acknowledgement import Acknowledgement, CommandOutcome
from wbc.teleop.capabilities import Capabilities
from wbc.teleop.channel import CommandChannel
from wbc.teleop.commands import SentCommand, TeleopCommand

#: Called with every command and what became of it, inside a tick: it must return at once.
AcknowledgementObserver = Callable[[SentCommand, Acknowledgement], None]


class Arrival(NamedTuple):
    """A command with the channel that it came through; None if it was submitted in the process."""

    sent: SentCommand
    channel: CommandChannel | None


class CommandInbox:
    """The commands that wait for the next tick.

    Args:
        robot: the robot that is commanded.
        capabilities: which commands the loop takes.
    """

    def __init__(self, robot: Robot, capabilities: Capabilities) -> None:
        self._robot, self._capabilities = robot, capabilities
        self._channels: list[CommandChannel] = []
        self._observers: list[AcknowledgementObserver] = []
        self._submitted: deque[SentCommand] = deque()
        self._numbers = itertools.count(1)

    def open_channel(self) -> CommandChannel:
        """Return a new channel for commands from another process."""
        channel = CommandChannel(self._robot, self._capabilities)
        self._channels.append(channel)
        return channel

    def submit(self, command: TeleopCommand, source: str) -> int:
        """Add a command of this process; return its number. Any thread may call this."""
        number = next(self._numbers)
        self._submitted.append(SentCommand(command, source, number, time.monotonic()))
        return number

    def add_observer(self, observer: AcknowledgementObserver) -> None:
        """Have every acknowledged command passed to a function."""
        self._observers.append(observer)

    def take(self) -> list[Arrival]:
        """Return the commands that have arrived since the last call, sender by sender."""
        arrivals = []
        while self._submitted:
            arrivals.append(Arrival(self._submitted.popleft(), None))
        for channel in self._channels:
            while (sent := channel.receive()) is not None:
                arrivals.append(Arrival(sent, channel))
        return arrivals

    def acknowledge(
        self, arrival: Arrival, outcome: CommandOutcome, reason: str, at: float
    ) -> None:
        """Tell the sender and the observers what became of a command.

        Args:
            arrival: the command.
            outcome: what became of it.
            reason: why; empty if it was accepted or done.
            at: time of the plant, s.
        """
        sent, channel = arrival
        acknowledgement = Acknowledgement(sent.id, outcome, reason, at)
        if channel is not None:
            channel.acknowledge(acknowledgement)
        for observer in self._observers:
            observer(sent, acknowledgement)

    def close(self) -> None:
        """Close the channels."""
        for channel in self._channels:
            channel.close()
        self._channels.clear()
