"""What the loop does with requests: between two ticks, from shared memory, without waiting."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wbc.live.knobs import Setting, gain_knobs, gait_knobs, speed_knob, velocity_knobs
from wbc.live.panel import Kind, Panel
from wbc.live.pushes import PushCount
from wbc.motions import Motion, MotionPlayer, unpack
from wbc.motions.engine.blob_buffer import BlobBuffer
from wbc.motions.engine.manager import MotionManager
from wbc.process import RecordRing
from wbc.runtime.clock import Clock
from wbc.runtime.loop import StopRun

RECORD = 3  # numbers of a request: kind and two arguments
_NAP = 0.005  # s between two looks while nothing moves
_HARDEST = 0.6  # m/s: the largest push changes the robot's velocity by that
NO_MOTION, RETURNING = -1, -2


class Helm:
    """Steers a player by requests, and paces its ticks; `before_tick` of `wbc.run`.

    One thing at a time, see `MotionManager`. Motions come packed with their plans: none is
    checked or planned here.

    Args:
        player: whom to steer.
        plant: what it is in; it may have `push` and `reset`.
        motions: that may be asked for.
        idle: called while it is paused or lies, every few milliseconds.

    Attributes:
        manager: through which.
        panel: what may be asked for.
        requests: where it is asked.
        shelf: where motions lie that are asked for.
        pushes: and what became of them.
        paused: it stands still in time.
        taken: how many requests have been taken.
        reset_wanted: a reset was asked for, and the run ended for it.
        stop: asked while it is paused; ends the run.
    """

    def __init__(
        self,
        player: MotionPlayer,
        plant: Any,
        motions: Sequence[type[Motion]],
        idle: Callable[[], None],
    ) -> None:
        self._performer, self._plant, self._idle = player, plant, idle
        walker = player.walker
        self._settings: list[Setting] = [
            *velocity_knobs(walker, self._turn_velocity),
            speed_knob(self._turn_speed),
            *gait_knobs(walker),
            *gain_knobs(player),
        ]
        hardest = _HARDEST * player.robot.mass
        self.panel = Panel(
            tuple(setting.knob for setting in self._settings),
            tuple(motions),
            float(f"{hardest:.2g}"),
        )
        self.requests = RecordRing(RECORD)
        self.shelf = BlobBuffer()
        self.pushes = PushCount()
        self.paused = self.reset_wanted = False
        self.taken = 0
        self.manager = MotionManager(player)
        self._push_torso = getattr(plant, "push", None)
        self._clock = Clock(player.dt, 1)
        self._fresh = True
        self.stop: Callable[[], bool] = lambda: False

    def begin(self) -> None:
        """A run begins: what was asked for before it is forgotten."""
        for kind, first, second in self.requests.read():
            self.taken += 1
            if kind == Kind.KNOB:
                self._settings[int(first)].turn(float(second))
        self.pushes.restart()
        self.manager.reset()
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
        self.manager.update()
        for impulse in self._performer.pop_pushes():
            self._push(impulse)
        self.pushes.tick(self._plant.time)

    def lie(self) -> None:
        """Fallen: nothing but a reset helps. Look whether one is wanted."""
        self._take()
        self._idle()
        time.sleep(_NAP)

    @property
    def playing(self) -> int:
        """Index of the motion that is going on, `NO_MOTION` or `RETURNING`."""
        playing = self._performer.playing
        if playing is not None:
            return self.panel.motions.index(type(playing))
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
                heading = self._performer.walker.standing_frame.rotation
                self._push(heading @ np.array([first, second, 0.0]))
            elif kind == Kind.MOTION:
                data = self.shelf.read(int(first), int(second))
                self.manager.play(unpack(data, self._performer.robot))
            elif kind == Kind.STAND:
                self.manager.stand()
            elif kind == Kind.PAUSE:
                self.paused = bool(first)
            else:
                self.reset_wanted = True

    def _turn_velocity(self, i: int, value: float) -> None:
        wanted = list(self.manager.velocity)
        wanted[i] = value
        self.manager.velocity = wanted

    def _turn_speed(self, value: float) -> None:
        self._clock = Clock(self._performer.dt / value, 1)

    def _push(self, impulse: np.ndarray) -> None:
        if self._push_torso is not None:
            self._push_torso(impulse)
            self.pushes.pushed(self._plant.time)
