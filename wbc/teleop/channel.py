"""Commands on their way from another process to the loop, and acknowledgements on the way back."""

from __future__ import annotations

import contextlib
import itertools
import pickle
import queue
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from wbc.motions import Motion, unpack
from wbc.motions.engine import MotionPlanner, PlannedMotion
from wbc.process import BlobQueue, BlobQueueFull, BlobTooLarge
from wbc.robot import Robot
from wbc.teleop.acknowledgement import Acknowledgement, CommandOutcome, CommandRefused
from wbc.teleop.capabilities import Capabilities
from wbc.teleop.commands import (
    MotionCommand,
    ResetCommand,
    SentCommand,
    StandCommand,
    TeleopCommand,
    VelocityCommand,
)

_COMMANDS = (32, 1 << 19)  # slots and their size, bytes: it takes 2 ms to unpickle so much
_ACKNOWLEDGEMENTS = (256, 1 << 12)
_MAX_REASON = 800  # characters
_PLANNING_TIMEOUT = 30.0  # s


@dataclass(frozen=True, slots=True)
class _PackedMotion:
    """A motion command on its way: the motion is packed with its plans, without the robot."""

    data: bytes


@dataclass(frozen=True, eq=False)
class ChannelConfig:
    """The data that another process needs to open its end of a channel.

    Attributes:
        capabilities: commands that the loop takes, with their bounds.
        commands: descriptor of the queue of commands.
        acknowledgements: descriptor of the queue of acknowledgements.
    """

    capabilities: Capabilities
    commands: int
    acknowledgements: int

    @property
    def descriptors(self) -> tuple[int, int]:
        """File descriptors that the other process inherits."""
        return (self.commands, self.acknowledgements)


class CommandChannel:
    """The loop's end of a channel. It never waits.

    Args:
        robot: the robot that is commanded.
        capabilities: commands that the loop takes, with their bounds.
    """

    def __init__(self, robot: Robot, capabilities: Capabilities) -> None:
        self._robot = robot
        self._commands = BlobQueue(*_COMMANDS)
        self._acknowledgements = BlobQueue(*_ACKNOWLEDGEMENTS)
        self.config = ChannelConfig(
            capabilities, self._commands.descriptor, self._acknowledgements.descriptor
        )

    def receive(self) -> SentCommand | None:
        """Return the next command; None if there is none."""
        data = self._commands.get()
        if data is None:
            return None
        # The sender is a child process of our own: unpickling may run any code.
        command, source, number, stamp = pickle.loads(data)
        if isinstance(command, _PackedMotion):
            command = MotionCommand(unpack(command.data, self._robot))
        return SentCommand(command, source, number, stamp, self.acknowledge)

    def acknowledge(self, acknowledgement: Acknowledgement) -> None:
        """Tell the sender what became of a command. A sender that does not read misses it."""
        short = replace(acknowledgement, reason=acknowledgement.reason[:_MAX_REASON])
        with contextlib.suppress(BlobQueueFull):
            self._acknowledgements.put(pickle.dumps(short))

    def close(self) -> None:
        """Close the descriptors."""
        self._commands.close()
        self._acknowledgements.close()


class CommandClient:
    """Another process's end of a channel: validates commands, plans motions, and sends both.

    A motion is planned in a thread and sent when its plan is there, unless another command
    supersedes it meanwhile: another motion, standing, a reset, or, for a motion that cannot be
    played while walking, a velocity other than zero.

    Args:
        robot: the robot that is commanded.
        config: configuration of the channel.
        source: sender of the commands, e.g. "ros".
        planned_ahead: motions that are planned, with their default parameters, when there is
            nothing else to plan.

    Attributes:
        capabilities: commands that the loop takes, with their bounds.
        infeasible: name of a motion -> why the robot cannot play it with its default parameters.
        on_motion_sent: called when a motion has been planned and sent.
    """

    def __init__(
        self,
        robot: Robot,
        config: ChannelConfig,
        source: str,
        planned_ahead: Sequence[type[Motion]] = (),
    ) -> None:
        self.capabilities = config.capabilities
        self.infeasible: dict[str, str] = {}
        self.on_motion_sent: Callable[[Motion], None] = lambda _: None
        self._source = source
        self._commands = BlobQueue(*_COMMANDS, config.commands)
        self._received = BlobQueue(*_ACKNOWLEDGEMENTS, config.acknowledgements)
        self._numbers = itertools.count(1)
        self._own: list[Acknowledgement] = []  # of motions that never reached the loop
        self._planning: tuple[int, Motion, str] | None = None
        self._planning_end = 0.0  # s by `time.monotonic`
        self._plans: queue.SimpleQueue[PlannedMotion] = queue.SimpleQueue()
        self._planner = MotionPlanner(robot, planned_ahead, self._plans.put)

    def start_planning(self) -> None:
        """Start the thread that plans motions."""
        self._planner.start()

    @property
    def planning(self) -> Motion | None:
        """The motion that is being planned, to be sent next."""
        return None if self._planning is None else self._planning[1]

    def send(self, command: TeleopCommand, source: str = "") -> int:
        """Validate a command and send it, or plan its motion first.

        Args:
            command: the command.
            source: sender of the command; by default the client's own source.

        Returns:
            Its number, by which it is acknowledged.

        Raises:
            CommandRefused: it is invalid for this robot, or the loop takes no commands.
        """
        self.capabilities.check(command)
        number = next(self._numbers)
        source = source or self._source
        if isinstance(command, MotionCommand):
            self._supersede("another motion took its place")
            self._planning = (number, command.motion, source)
            self._planning_end = time.monotonic() + _PLANNING_TIMEOUT
            plan = self._planner.cached(command.motion)
            if plan is not None:
                self._send_planned(plan)
            else:
                self._planner.request(command.motion)
            return number
        self._put(command, source, number)
        match command:
            case VelocityCommand():
                walks = any(command.velocity)
                if walks and self.planning is not None and not self.planning.while_walking:
                    self._supersede("the robot was commanded to walk")
            case StandCommand():
                self._supersede("the robot was commanded to stand")
            case ResetCommand():
                self._supersede("the robot was reset")
        return number

    def poll(self) -> list[Acknowledgement]:
        """Send the motion that has been planned; return the acknowledgements since the last call.

        Call it at least some ten times per second.
        """
        while True:
            try:
                self._send_planned(self._plans.get_nowait())
            except queue.Empty:
                break
        if self._planning is not None and time.monotonic() > self._planning_end:
            number, motion, _ = self._planning
            self._planning = None
            self._planner.abandon()
            reason = f"{motion.name}: planning takes more than {_PLANNING_TIMEOUT:g} s"
            self._own.append(Acknowledgement(number, CommandOutcome.REFUSED, reason))
        while (data := self._received.get()) is not None:
            self._own.append(pickle.loads(data))
        found, self._own = self._own, []
        return found

    def _send_planned(self, plan: PlannedMotion) -> None:
        name = plan.motion.name
        if plan.error and self._planner.cached(plan.motion):
            self.infeasible.setdefault(name, plan.error)
        if self._planning is None or self._planning[1] != plan.motion:
            return
        number, _, source = self._planning
        self._planning = None
        try:
            if plan.error:
                raise CommandRefused(plan.error)
            self._put(_PackedMotion(plan.packed), source, number)
        except CommandRefused as error:
            self._own.append(Acknowledgement(number, CommandOutcome.REFUSED, str(error)))
            return
        self.on_motion_sent(plan.motion)

    def _supersede(self, reason: str) -> None:
        """Forget the motion that is being planned."""
        if self._planning is not None:
            self._own.append(Acknowledgement(self._planning[0], CommandOutcome.SUPERSEDED, reason))
            self._planning = None
            self._planner.abandon()

    def cancel_planning(self) -> None:
        """Forget the motion that is being planned; it is acknowledged as superseded."""
        self._supersede("cancelled")

    def _put(self, command: TeleopCommand | _PackedMotion, source: str, number: int) -> None:
        data = pickle.dumps((command, source, number, time.monotonic()))
        try:
            self._commands.put(data)
        except BlobQueueFull:
            raise CommandRefused(
                "too many commands at once: the loop takes them between its ticks"
            ) from None
        except BlobTooLarge as error:
            raise CommandRefused(
                f"the plan of this motion is too large: {error} within a tick; make it shorter"
            ) from None
