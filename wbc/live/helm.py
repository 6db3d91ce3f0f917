"""What the loop does with requests: between two ticks, from shared memory, without waiting."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wbc.clock import Clock
from wbc.gait import Velocity
from wbc.live.cleared import Cleared
from wbc.live.knobs import Setting, gain_knobs, gait_knobs, speed_knob, velocity_knobs
from wbc.live.panel import Kind, Panel
from wbc.live.pushes import PushCount
from wbc.loop import StopRun
from wbc.motions import Motion, Performer
from wbc.process import RecordRing

RECORD = 3  # numbers of a request: kind and two arguments
STANDING = (0.0, 0.0, 0.0)
_NAP = 0.005  # s between two looks while nothing moves
_HARDEST = 0.6  # m/s: the largest push changes the robot's velocity by that
NO_MOTION, RETURNING = -1, -2


class Helm:
    """Steers a performer by requests, and paces its ticks; `before_tick` of `wbc.run`.

    One thing at a time: a motion that is asked for while the robot walks, or plays another,
    begins when it is back to standing; so does walking.

    Args:
        performer: whom to steer.
        plant: what it is in; it may have `push` and `reset`.
        motions: that may be asked for.
        idle: called while it is paused or lies, every few milliseconds.

    Attributes:
        panel: what may be asked for.
        requests: where it is asked.
        pushes: and what became of them.
        paused: it stands still in time.
        taken: how many requests have been taken.
        reset_wanted: a reset was asked for, and the run ended for it.
        stop: asked while it is paused; ends the run.
    """

    def __init__(
        self,
        performer: Performer,
        plant: Any,
        motions: Sequence[type[Motion]],
        idle: Callable[[], None],
    ) -> None:
        self._performer, self._plant, self._idle = performer, plant, idle
        walker = performer.walker
        self._settings: list[Setting] = [
            *velocity_knobs(walker, self._turn_velocity),
            speed_knob(self._turn_speed),
            *gait_knobs(walker),
            *gain_knobs(performer),
        ]
        hardest = _HARDEST * performer.robot.mass
        self.panel = Panel(
            tuple(setting.knob for setting in self._settings),
            tuple(motions),
            float(f"{hardest:.2g}"),
        )
        self.requests = RecordRing(RECORD)
        self.pushes = PushCount()
        self.paused = self.reset_wanted = False
        self.taken = 0
        self._wanted = self._given = STANDING
        self._next: int | None = None
        self._playing = NO_MOTION
        self._clock = Clock(performer.dt, 1)
        self._fresh = True
        self.stop: Callable[[], bool] = lambda: False

    def begin(self) -> None:
        """A run begins: what was asked for before it is forgotten."""
        for kind, first, second in self.requests.read():
            self.taken += 1
            if kind == Kind.KNOB:
                self._settings[int(first)].turn(float(second))
        self.pushes.restart()
        self._wanted = self._given = STANDING
        self._next, self._playing = None, NO_MOTION
        self.paused = self.reset_wanted = False
        self._fresh = True

    def __call__(self, _: float) -> None:
        """Wait for the tick's time, then do what is asked.

        Raises:
            StopRun: a reset is wanted.
        """
        self._clock.wait()
        self._take()
        # The first tick of a run is not waited with: it shows where the robot stands.
        while self.paused and not self._fresh and not self._reset_due():
            if self.stop():
                raise StopRun("stopped")
            self._idle()
            time.sleep(_NAP)
            self._take()
        if self._reset_due():
            raise StopRun("reset")
        self._fresh = False
        self._steer()
        self.pushes.tick(self._plant.time)

    def lie(self) -> None:
        """Fallen: nothing but a reset helps. Look whether one is wanted."""
        self._take()
        self._idle()
        time.sleep(_NAP)

    @property
    def playing(self) -> int:
        """Index of the motion that is going on, `NO_MOTION` or `RETURNING`."""
        if self._performer.playing is not None:
            return self._playing
        return NO_MOTION if self._performer.idle else RETURNING

    def _reset_due(self) -> bool:
        # A run that has had no tick yet is as good as reset.
        self.reset_wanted = self.reset_wanted and not self._fresh
        return self.reset_wanted

    def _take(self) -> None:
        for kind, first, second in self.requests.read():
            self.taken += 1
            if kind == Kind.KNOB:
                self._settings[int(first)].turn(float(second))
            elif kind == Kind.PUSH:
                self._push(first, second)
            elif kind == Kind.MOTION:
                self._play(int(first))
            elif kind == Kind.STAND:
                self._stand()
            elif kind == Kind.PAUSE:
                self.paused = bool(first)
            else:
                self.reset_wanted = True

    def _turn_velocity(self, i: int, value: float) -> None:
        wanted = list(self._wanted)
        wanted[i] = value
        self._wanted = (wanted[0], wanted[1], wanted[2])
        self._next = None
        if self._performer.playing is not None and self._wanted != STANDING:
            self._performer.interrupt()

    def _turn_speed(self, value: float) -> None:
        self._clock = Clock(self._performer.dt / value, 1)

    def _push(self, forward: float, left: float) -> None:
        heading = self._performer.walker.standing_frame.rotation
        self._plant.push(heading @ np.array([forward, left, 0.0]))
        self.pushes.pushed(self._plant.time)

    def _play(self, index: int) -> None:
        self._stand()
        self._next = index

    def _stand(self) -> None:
        performer = self._performer
        self._wanted = STANDING
        self._next = None
        # On its way back to standing it goes on, and standing there is nothing to leave off.
        if performer.playing is not None or (performer.idle and not performer.body.at_home):
            performer.interrupt()
            self._given = STANDING

    def _steer(self) -> None:
        performer = self._performer
        if not performer.idle:
            self._given = STANDING
        elif self._next is not None:
            self._playing, self._next = self._next, None
            performer.play(Cleared(self.panel.motions[self._playing]()))
        elif self._wanted != self._given:
            # Clamped here, since the walker's own way of saying so takes a warning per tick.
            self._given = self._wanted
            wanted = Velocity(*self._wanted).clamped(performer.walker.gait)
            performer.velocity = (wanted.forward, wanted.left, wanted.turn)
