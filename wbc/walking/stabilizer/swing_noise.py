"""What looks like a push in every swing of a robot whose joints have play, or follow late."""

from __future__ import annotations

import math
from collections import deque
from statistics import median

from wbc.gait import GaitState, Phase
from wbc.walking.stabilizer.disturbance import NO_PUSH

_SWINGS = 5  # that are remembered
_UNKNOWN_PEAK = 2.0  # m/s, of a robot that has not taken that many yet


class SwingNoise:
    """Learns from swings without a push what seems to be a disturbance in them.

    Joints with play, and servos that follow late, let the DCM differ from what was commanded: at
    every lift-off as fast as in a push. The peaks of most steps are alike, however.

    Attributes:
        level: rate up to which there is no push, m/s: `n + 2 (median of the peaks − n)`, where n
            is that of a robot whose joints do as they are told.
    """

    def __init__(self) -> None:
        self._peak = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget what was learned: a robot may be like any."""
        self._peaks = deque([_UNKNOWN_PEAK] * _SWINGS, _SWINGS)
        self._set_level()

    def update(self, state: GaitState) -> None:
        """Learn from the disturbance of this tick."""
        if state.phase is not Phase.SWING:
            if self._peak > 0.0:
                self._peaks.append(self._peak)
                self._peak = 0.0
                self._set_level()
        elif state.shortened or state.recovering:
            self._peak = -math.inf
        else:
            self._peak = max(self._peak, abs(state.disturbance))

    def _set_level(self) -> None:
        self.level = NO_PUSH + 2.0 * max(median(self._peaks) - NO_PUSH, 0.0)
