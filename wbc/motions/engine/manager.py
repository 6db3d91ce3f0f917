"""The motion manager: decides what a motion player does next, whatever is commanded and when."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from wbc.gait import Velocity
from wbc.motions.engine.motion import Motion
from wbc.motions.engine.player import MotionPlayer

ZERO_VELOCITY = (0.0, 0.0, 0.0)


class MotionStatus(IntEnum):
    """Status of the motion that was commanded last."""

    NONE = 0  #: no motion has been commanded
    WAITING = 1  #: for the robot to stand
    PLAYING = 2
    RETURNING = 3  #: to standing, after the motion was canceled or aborted
    DONE = 4
    ABORTED = 5  #: the context's last note says why
    CANCELED = 6  #: in favour of another command


class MotionManager:
    """Makes a player walk, play motions and stand, one thing at a time, between two ticks.

    A motion that is commanded while the robot walks, or plays another, begins when the robot
    stands again; so does walking. Only a motion for `while_walking` combines with walking.
    Motions are neither checked nor planned here: they come prepared.

    Args:
        player: the player.

    Attributes:
        status: status of the motion that was commanded last.
    """

    def __init__(self, player: MotionPlayer) -> None:
        self._player = player
        self.reset()

    def reset(self) -> None:
        """Forget all commands: a run begins."""
        self._commanded = self._applied = ZERO_VELOCITY
        self._next: Motion | None = None
        self._current: Motion | None = None
        self._aborted = 0
        self._outcome = MotionStatus.DONE
        self.status = MotionStatus.NONE

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Commanded velocity: forward, left (m/s) and turn left (rad/s).

        Any velocity but zero cancels a motion that does not combine with walking.
        """
        return self._commanded

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        forward, left, turn = value
        self._commanded = (float(forward), float(left), float(turn))
        if self._commanded == ZERO_VELOCITY:
            return
        playing = self._player.playing
        if self._next is not None and not self._next.while_walking:
            self._cancel()
        elif playing is not None and not playing.while_walking:
            self._cancel()
            self._player.interrupt()

    @property
    def waiting(self) -> Motion | None:
        """The motion that begins when the robot stands."""
        return self._next

    def play(self, motion: Motion) -> None:
        """Play a motion that has been prepared, instead of what is playing or waiting."""
        player = self._player
        self._cancel()
        self._current, self.status = motion, MotionStatus.WAITING
        if not motion.while_walking:
            self._commanded = ZERO_VELOCITY
        elif self._may_walk:
            player.blend(motion)
            self._start_watching()
            return
        self._return_to_standing()
        self._next = motion

    def stand(self) -> None:
        """Cancel whatever the robot does, and come to a stand."""
        self._commanded = ZERO_VELOCITY
        self._cancel()
        self._return_to_standing()

    def update(self) -> None:
        """Start what is next, if it is time for it; call this before each tick."""
        player = self._player
        self._update_status(player.playing)
        if not self._may_walk:
            self._applied = ZERO_VELOCITY
        elif self._next is not None:
            motion, self._next = self._next, None
            player.play(motion)
            self._start_watching()
        elif self._commanded != self._applied:
            # Clamped here, because the walker would warn at every tick.
            self._applied = self._commanded
            clamped = Velocity(*self._commanded).clamped(player.walker.gait)
            player.velocity = (clamped.forward, clamped.left, clamped.turn)

    @property
    def _may_walk(self) -> bool:
        """Whether nothing is going on that walking would have to wait for."""
        playing = self._player.playing
        return self._player.idle or (playing is not None and playing.while_walking)

    def _start_watching(self) -> None:
        self._aborted = len(self._player.aborted_motions)
        self.status = MotionStatus.PLAYING

    def _cancel(self) -> None:
        """Cancel the motion that waits or plays."""
        self._next = None
        if self.status in (MotionStatus.WAITING, MotionStatus.PLAYING):
            self.status, self._outcome = MotionStatus.RETURNING, MotionStatus.CANCELED

    def _return_to_standing(self) -> None:
        player = self._player
        # A player on its way back continues; one that stands has nothing to interrupt.
        if player.playing is not None or (player.idle and not player.context.at_home):
            player.interrupt()
            self._applied = ZERO_VELOCITY

    def _update_status(self, playing: Motion | None) -> None:
        """Update the status: a tick has passed since the motion was handed to the player."""
        if self.status is MotionStatus.PLAYING and playing is not self._current:
            aborted = len(self._player.aborted_motions) > self._aborted
            self.status = MotionStatus.RETURNING
            self._outcome = MotionStatus.ABORTED if aborted else MotionStatus.DONE
        if self.status is MotionStatus.RETURNING and self._player.idle:
            self.status = self._outcome
