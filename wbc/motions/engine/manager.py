"""Who says what a player does next: one thing at a time, whatever is asked and whenever."""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum

from wbc.gait import Velocity
from wbc.motions.engine.motion import Motion
from wbc.motions.engine.player import MotionPlayer

STANDING = (0.0, 0.0, 0.0)


class MotionStatus(IntEnum):
    """What became of the motion that was asked for last."""

    NONE = 0  #: none has been asked for
    WAITING = 1  #: for the robot to stand
    PLAYING = 2
    RETURNING = 3  #: to standing, after it was left off or gave up
    DONE = 4
    ABORTED = 5  #: the player's last note says why
    CANCELED = 6  #: for something else


class MotionManager:
    """Has a player walk, play and stand, between two ticks.

    A motion that is asked for while the robot walks, or plays another, begins when it is back to
    standing; so does walking. Only a motion for `while_walking` goes along with it. None is
    checked or planned here: they come prepared.

    Args:
        player: who does it.

    Attributes:
        stage: of the motion that was asked for last.
    """

    def __init__(self, player: MotionPlayer) -> None:
        self._performer = player
        self.begin()

    def begin(self) -> None:
        """A run begins: what was asked for before it is forgotten."""
        self._wanted = self._given = STANDING
        self._next: Motion | None = None
        self._current: Motion | None = None
        self._given_up = 0
        self._outcome = MotionStatus.DONE
        self.status = MotionStatus.NONE

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Forward, left (m/s) and turn left (rad/s), as wanted.

        A motion that does not go along with walking ends for any velocity but zero.
        """
        return self._wanted

    @velocity.setter
    def velocity(self, value: Sequence[float]) -> None:
        forward, left, turn = value
        self._wanted = (float(forward), float(left), float(turn))
        if self._wanted == STANDING:
            return
        playing = self._performer.playing
        if self._next is not None and not self._next.while_walking:
            self._drop()
        elif playing is not None and not playing.while_walking:
            self._drop()
            self._performer.interrupt()

    @property
    def waiting(self) -> Motion | None:
        """The motion that begins when the robot stands."""
        return self._next

    def play(self, motion: Motion) -> None:
        """Play a motion that has been prepared, instead of what goes on or waits."""
        player = self._performer
        self._drop()
        self._current, self.status = motion, MotionStatus.WAITING
        if not motion.while_walking:
            self._wanted = STANDING
        elif self._may_walk:
            player.blend(motion)
            self._handed_over()
            return
        self._leave_off()
        self._next = motion

    def stand(self) -> None:
        """Leave off whatever it is, and come to a stand."""
        self._wanted = STANDING
        self._drop()
        self._leave_off()

    def steer(self) -> None:
        """Before a tick: go on to what is next, if it is time for it."""
        player = self._performer
        self._watch(player.playing)
        if not self._may_walk:
            self._given = STANDING
        elif self._next is not None:
            motion, self._next = self._next, None
            player.play(motion)
            self._handed_over()
        elif self._wanted != self._given:
            # Clamped here, since the walker's own way of saying so takes a warning per tick.
            self._given = self._wanted
            wanted = Velocity(*self._wanted).clamped(player.walker.gait)
            player.velocity = (wanted.forward, wanted.left, wanted.turn)

    @property
    def _may_walk(self) -> bool:
        """Nothing goes on that walking would have to wait for."""
        playing = self._performer.playing
        return self._performer.idle or (playing is not None and playing.while_walking)

    def _handed_over(self) -> None:
        self._given_up = len(self._performer.aborted_motions)
        self.status = MotionStatus.PLAYING

    def _drop(self) -> None:
        """The motion that waits or plays is not wanted any more."""
        self._next = None
        if self.status in (MotionStatus.WAITING, MotionStatus.PLAYING):
            self.status, self._outcome = MotionStatus.RETURNING, MotionStatus.CANCELED

    def _leave_off(self) -> None:
        player = self._performer
        # On its way back to standing it goes on, and standing there is nothing to leave off.
        if player.playing is not None or (player.idle and not player.context.at_home):
            player.interrupt()
            self._given = STANDING

    def _watch(self, playing: Motion | None) -> None:
        """See what became of the motion: a tick has passed since it was handed over."""
        if self.status is MotionStatus.PLAYING and playing is not self._current:
            gave_up = len(self._performer.aborted_motions) > self._given_up
            self.status = MotionStatus.RETURNING
            self._outcome = MotionStatus.ABORTED if gave_up else MotionStatus.DONE
        if self.status is MotionStatus.RETURNING and self._performer.idle:
            self.status = self._outcome
