"""Applies commands to a robot in a running loop, between two ticks."""

from __future__ import annotations

import itertools
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wbc.closeable import Closeable
from wbc.motions import MOTIONS, Motion, MotionPlayer
from wbc.motions.engine import ZERO_VELOCITY, MotionManager, MotionStatus
from wbc.runtime.clock import Clock
from wbc.runtime.loop import StopRun
from wbc.runtime.mode import Mode
from wbc.runtime.schema import Quantity
from wbc.teleop import commands
from wbc.teleop.acknowledgement import Acknowledgement, CommandOutcome
from wbc.teleop.capabilities import Capabilities
from wbc.teleop.channel import CommandChannel
from wbc.teleop.frame_tasks import FrameTasks
from wbc.teleop.hand_targets import HandTargets
from wbc.teleop.joint_targets import JointTargets
from wbc.teleop.parameters import GAIT, set_parameter
from wbc.teleop.push_counter import PushCounter
from wbc.teleop.session_choices import SessionChoices

#: Called with every command and what became of it, inside a tick: it must return at once.
AcknowledgementObserver = Callable[[commands.SentCommand, Acknowledgement], None]

_IDLE_PERIOD = 0.005  # s between two looks for commands while nothing moves
#: Values of the quantity `motion_playing` while no motion plays.
NO_MOTION, RETURNING = -1, -2
_COMMANDS_PER_TICK = 4  # of each channel: a flood of them, 70 µs each, makes no tick late
_FALLEN = "the robot has fallen: reset it first"
_WHILE_FALLEN = (
    *commands.PARAMETER_COMMANDS,
    commands.PauseCommand,
    commands.ResetCommand,
    commands.StartSessionCommand,
)


class CommandHandler(Closeable):
    """Takes commands from any number of senders and applies them before a tick.

    A script calls `submit`; other processes send through a channel that `open_channel` makes. The
    commands that have arrived are applied in `before_tick`, in the order in which each sender sent
    them, and change the very next command to the motors. Nothing is planned here: motions come
    prepared. A velocity ends by its timeout, even if its sender has died.

    Args:
        player: the controller.
        plant: may have `push` and `reset`.
        motions: motions that can be played; by default all registered motions.
        owns_clock: wait for the wall clock in `before_tick`, so that the loop can run slower than
            real time; otherwise whoever runs the loop keeps the time.
        sessions: what another session may be started with; whoever runs the loop starts it when
            `next_session` is set.

    Attributes:
        capabilities: commands that are taken, and their bounds.
        mode: whether the loop runs, is paused, or waits for a reset.
        paused: whether the loop is to pause.
        reset_wanted: whether a reset has been accepted since the run began.
        next_session: the session that is to be started in place of this one; None for none.
        pushes: counter of the pushes that were survived.
        quantities: quantities of the stream of ticks beside those of the library.
        on_idle: called with the mode, every few milliseconds, while there are no ticks.
        on_timeout: called with a line of text when a velocity ends by its timeout.
        stop: returns whether to end the run while it is paused.

    Raises:
        MotionError: another process could not import a motion.
    """

    def __init__(
        self,
        player: MotionPlayer,
        plant: Any,
        *,
        motions: Sequence[type[Motion]] = MOTIONS,
        owns_clock: bool = True,
        sessions: SessionChoices | None = None,
    ) -> None:
        self.player, self.plant = player, plant
        self.capabilities = Capabilities.of(player, plant, motions, owns_clock, sessions)
        self.next_session: commands.StartSessionCommand | None = None
        self.mode = Mode.RUNNING
        self.paused = self.reset_wanted = False
        self.pushes = PushCounter()
        self._manager = MotionManager(player)
        self._joints, self._hands = JointTargets(player), HandTargets(player)
        self._frame_tasks = FrameTasks(player)
        self._clock = Clock(player.dt, 1) if owns_clock else None
        self._channels: list[CommandChannel] = []
        self._observers: list[AcknowledgementObserver] = []
        self._submitted: deque[commands.SentCommand] = deque()
        self._numbers = itertools.count(1)
        self._motion: commands.SentCommand | None = None  # in progress
        self._resets: list[commands.SentCommand] = []  # in progress
        self._motion_end = ""  # why the motion in progress is to end
        self._velocity: commands.SentCommand | None = None  # in force, until its end:
        self._velocity_end = np.inf  # s by `time.monotonic`
        self._pull, self._pull_end = commands.PullCommand(), np.inf  # s by `time.monotonic`
        self._first_tick = True
        self.quantities = (
            Quantity(
                "motion_playing",
                lambda _: self._motion_index(),
                "index of the motion that plays; −1 none, −2 returning to standing",
            ),
            Quantity("pushes_decided", lambda _: self.pushes.decided, "pushes survived or not"),
            Quantity("pushes_survived", lambda _: self.pushes.survived, "pushes survived"),
            *self._hands.quantities(),
        )
        self.on_idle: Callable[[Mode], None] = lambda _: None
        self.on_timeout: Callable[[str], None] = lambda _: None
        self.stop: Callable[[], bool] = lambda: False

    # Senders.

    def open_channel(self) -> CommandChannel:
        """Return a new channel for commands from another process."""
        self._channels.append(CommandChannel(self.player.robot, self.capabilities))
        return self._channels[-1]

    def submit(self, command: commands.TeleopCommand, source: str = "script") -> int:
        """Validate a command, to be applied before the next tick; any thread may call this.

        A motion that is not prepared is prepared here, which may take a second.

        Returns:
            Number of the command, by which it is acknowledged to the observers.

        Raises:
            CommandRefused: the command is invalid for this robot.
            MotionError: the robot cannot play the motion.
        """
        self.capabilities.check(command)
        if isinstance(command, commands.MotionCommand):
            command.motion.prepare(self.player.robot)
        number = next(self._numbers)
        self._submitted.append(commands.SentCommand(command, source, number, time.monotonic()))
        return number

    def add_observer(self, observer: AcknowledgementObserver) -> None:
        """Have every acknowledged command passed to a function, e.g. for a log."""
        self._observers.append(observer)

    def remove_observer(self, observer: AcknowledgementObserver) -> None:
        """Undo `add_observer`."""
        self._observers.remove(observer)

    # The loop.

    def begin(self) -> None:
        """Prepare for a run. If a reset caused it, commands from before it are discarded."""
        if self._resets:
            for sent in self._arrived(None):
                if isinstance(sent.command, commands.PARAMETER_COMMANDS):
                    self._apply(sent)
                else:
                    self._acknowledge(sent, CommandOutcome.SUPERSEDED, "the robot was reset")
        self._end_motion(CommandOutcome.SUPERSEDED, "the robot was reset")
        self._manager.reset()
        self._joints.clear()
        self._hands.clear()
        self._frame_tasks.clear()
        self._velocity, self._velocity_end = None, np.inf
        self._pull, self._pull_end = commands.PullCommand(), np.inf
        self.pushes.on_reset()
        self.mode = Mode.RUNNING
        self.paused = self.reset_wanted = False
        self._first_tick = True

    def before_tick(self, _: float) -> None:
        """Wait for the tick's time if the clock is owned, then apply the commands.

        Raises:
            StopRun: the robot is to be reset, another session is to be started, or the run was
                stopped while it was paused.
        """
        if self._clock is not None:
            self._clock.wait()
        self._receive()
        # The first tick of a run is made even when paused: it shows where the robot stands.
        while self.paused and not self._first_tick and not self.reset_wanted:
            if self.stop() or self.next_session is not None:
                raise StopRun("stopped")
            self.mode = Mode.PAUSED
            self._idle()
            self._receive()
        if self.reset_wanted:
            raise StopRun("reset")
        if self.next_session is not None and not self._first_tick:
            raise StopRun("another session")
        for sent in self._resets:  # with no tick yet, the robot stands where it started
            self._acknowledge(sent, CommandOutcome.DONE)
        self._resets.clear()
        self.mode = Mode.RUNNING
        self._first_tick = False
        if time.monotonic() >= self._velocity_end:
            self._end_velocity()
        if time.monotonic() >= self._pull_end:
            self._set_pull(commands.PullCommand(), np.inf)
        self._manager.update()
        self._track_motion()
        self._joints.advance(time.monotonic())
        self._hands.advance()
        self._frame_tasks.advance()
        for impulse in self.player.pop_pushes():
            self._push(impulse)
        self.pushes.on_tick(self.plant.time)

    def idle_after_fall(self) -> None:
        """The robot has fallen: take commands for some milliseconds; only a reset helps."""
        if self.mode is not Mode.FALLEN:
            self.mode = Mode.FALLEN
            self.pushes.on_fall()
            self._end_motion(CommandOutcome.ABORTED, "the robot fell")
        self._receive()
        self._idle()

    def _idle(self) -> None:
        self.on_idle(self.mode)
        time.sleep(_IDLE_PERIOD)

    @property
    def owns_clock(self) -> bool:
        """Whether `before_tick` waits for the wall clock."""
        return self._clock is not None

    def status(self) -> dict[str, float]:
        """Return the values of `quantities` that change while there are no ticks."""
        return {"pushes_decided": self.pushes.decided, "pushes_survived": self.pushes.survived}

    def _motion_index(self) -> int:
        playing, motions = type(self.player.playing), self.capabilities.motions
        if playing in motions:
            return motions.index(playing)
        return NO_MOTION if self.player.idle else RETURNING

    @property
    def playing(self) -> Motion | None:
        """The motion that is playing; None while the robot stands, walks or returns to standing."""
        return self.player.playing

    @property
    def waiting(self) -> Motion | None:
        """The motion that begins as soon as the robot stands."""
        return self._manager.waiting

    # Commands.

    def _arrived(self, most: int | None) -> list[commands.SentCommand]:
        """Return the commands that have arrived since the last call, sender by sender.

        Args:
            most: largest number from each channel; None: all.
        """
        arrived = [self._submitted.popleft() for _ in range(len(self._submitted))]
        for channel in self._channels:
            arrived += itertools.islice(iter(channel.receive, None), most)
        return arrived

    def _receive(self) -> None:
        for sent in self._arrived(_COMMANDS_PER_TICK):
            self._apply(sent)

    def _apply(self, sent: commands.SentCommand) -> None:
        command = sent.command
        if isinstance(command, commands.KeepVelocityCommand):
            self._keep_velocity(sent, command)
            return
        if isinstance(command, commands.PullCommand) and command.link == self._pull.link != "":
            self._set_pull(command, sent.stamp + command.timeout)
            return
        if self.mode is Mode.FALLEN and not isinstance(command, _WHILE_FALLEN):
            self._acknowledge(sent, CommandOutcome.REFUSED, _FALLEN)
            return
        if isinstance(command, commands.HandTargetCommand) and (why := self._hands.set(command)):
            self._acknowledge(sent, CommandOutcome.REFUSED, why)
            return
        self._acknowledge(sent, CommandOutcome.ACCEPTED)
        match command:
            case commands.VelocityCommand(timeout=timeout):
                if any(command.velocity):
                    self._motion_end = f"{sent} took its place"
                self._manager.velocity = command.velocity
                self._velocity, self._velocity_end = sent, sent.stamp + timeout
            case commands.PullCommand(timeout=timeout):
                self._set_pull(command, sent.stamp + timeout if command.link else np.inf)
            case commands.PushCommand(impulse, duration, frame, link):
                vector = np.array(impulse)
                if frame == "heading":
                    vector = self.player.walker.standing_frame.rotation @ vector
                self._push(vector, duration, link)
            case commands.MotionCommand(motion):
                self._end_motion(CommandOutcome.SUPERSEDED, f"{sent} took its place")
                self._motion = sent
                self._manager.play(motion)
            case commands.StandCommand():
                self._motion_end = f"{sent} took its place"
                self._velocity, self._velocity_end = None, np.inf
                self._manager.stand()
                self._hands.stand()
            case commands.GaitParameterCommand(name, value):
                set_parameter(self.player.walker, f"{GAIT}.{name}", value)
            case commands.GainCommand(task_name, gain, value):
                set_parameter(self.player.walker, f"{task_name}.{gain}", value)
            case commands.FrameTaskCommand():
                self._frame_tasks.set(command)
            case commands.JointCommand():
                self._joints.set(command, sent.stamp)
            case commands.TimeScaleCommand(scale):
                self._clock = Clock(self.player.dt / scale, 1)
            case commands.PauseCommand(paused):
                self.paused = paused
            case commands.ResetCommand():
                self._resets.append(sent)
                self.reset_wanted = not self._first_tick
            case commands.StartSessionCommand():
                self.next_session = command

    def _keep_velocity(
        self, sent: commands.SentCommand, command: commands.KeepVelocityCommand
    ) -> None:
        velocity = self._velocity
        if velocity is not None and (velocity.id, velocity.reply) == (command.number, sent.reply):
            self._velocity_end = sent.stamp + command.timeout

    def _end_velocity(self) -> None:
        """Stop and stand, because the sender of the velocity has fallen silent."""
        velocity, self._velocity, self._velocity_end = self._velocity, None, np.inf
        walked = any(self._manager.velocity)
        self._manager.velocity = ZERO_VELOCITY
        if walked and velocity is not None:
            reason = f"nothing more came from the {velocity.source}: the robot stops and stands"
            self._acknowledge(velocity, CommandOutcome.ABORTED, reason)
            self.on_timeout(reason)

    def _push(self, impulse: np.ndarray, duration: float = 0.1, link: str = "") -> None:
        if self.capabilities.max_impulse:
            self.plant.push(impulse, duration=duration, **({"frame": link} if link else {}))
            self.pushes.on_push(self.plant.time)

    def _set_pull(self, command: commands.PullCommand, end: float) -> None:
        self._pull, self._pull_end = command, end
        if command.link:
            self.plant.pull(command.link, command.point, command.target)
        else:
            self.plant.release()

    def _track_motion(self) -> None:
        """Acknowledge the motion in progress when it is over and the robot stands."""
        if self._motion is None:
            return
        match self._manager.status:
            case MotionStatus.DONE:
                self._end_motion(CommandOutcome.DONE, "")
            case MotionStatus.ABORTED:
                self._end_motion(CommandOutcome.ABORTED, self.player.context.notes[-1])
            case MotionStatus.CANCELED:
                self._end_motion(CommandOutcome.SUPERSEDED, self._motion_end)

    def _end_motion(self, outcome: CommandOutcome, reason: str) -> None:
        if self._motion is not None:
            motion, self._motion = self._motion, None
            self._acknowledge(motion, outcome, reason)

    def _acknowledge(
        self, sent: commands.SentCommand, outcome: CommandOutcome, reason: str = ""
    ) -> None:
        acknowledgement = Acknowledgement(sent.id, outcome, reason, self.plant.time)
        sent.reply(acknowledgement)
        for observer in self._observers:
            observer(sent, acknowledgement)

    def close(self) -> None:
        """Close the channels."""
        for channel in self._channels:
            channel.close()
        self._channels.clear()
