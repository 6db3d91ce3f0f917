"""Disturbance observer: the force of a push, seen in the DCM before the DCM has moved far."""

from __future__ import annotations

from wbc.gait import GaitState

_TIME_CONSTANT = 0.01  # s, of the low-pass filter
NO_PUSH = 0.5  # m/s by which sensor noise and settling seem to move the DCM
_LASTS_ON = 3.0  # times as long as it has lasted: how long a push is taken to last on
_FAST = 4.0  # times as much in fast walking, where limits keep the CoM from its reference


class DisturbanceObserver:
    """Estimates how fast an unknown force moves the DCM.

    A force F on the robot adds F / (m ω) to what ZMP p and pivot offset δ do to the DCM,

        d = ξ̇ − ω (ξ − p − δ),

    low-pass filtered because ξ̇ is a difference of estimates (a disturbance observer after
    K. Ohnishi, M. Shibata, T. Murakami, Motion control for advanced mechatronics, 1996).

    Attributes:
        rate: d, ground vector, m/s.
        lasted: time for which it has been beyond noise, s.
    """

    def __init__(self) -> None:
        self.rate = 0j
        self.lasted = 0.0
        self._before: complex | None = None
        self._expected = 0j

    def reset(self) -> None:
        """Start anew, without a disturbance."""
        self.rate, self.lasted, self._expected, self._before = 0j, 0.0, 0j, None

    def update(self, dcm: complex, dt: float, noise: float = 0.0) -> complex:
        """Return the rate of the disturbance, m/s.

        Args:
            dcm: estimated ξ of this tick, m.
            dt: time since the last tick, s.
            noise: rate up to which there is no disturbance, m/s.
        """
        before, self._before = self._before, dcm
        if before is not None:
            rate = (dcm - before) / dt - self._expected
            self.rate += min(dt / _TIME_CONSTANT, 1.0) * (rate - self.rate)
            self.lasted = self.lasted + dt if abs(self.rate) > noise else 0.0
        return self.rate

    def expect(self, rate: complex) -> None:
        """Set the `ω (ξ − p − δ)` that the command of this tick leads to, m/s."""
        self._expected = rate


def noise_rate(state: GaitState) -> float:
    """Return the rate up to which noise and settling seem to move the DCM, m/s."""
    return state.disturbance_noise * (1.0 + (_FAST - 1.0) * state.fast_share)


def lasting_shift(state: GaitState, time: float) -> complex:
    """Return by how much a push will move the DCM yet within a time (s), a ground vector, m.

    A push is taken to last on in proportion to how long it has lasted: a joint that crosses its
    play moves the DCM as fast as a push does, but only for moments. The motion
    `ω (ξ − p)` of the pendulum itself is not in it.
    """
    size, least = abs(state.disturbance), noise_rate(state)
    if size <= least:
        return 0j
    return min(time, _LASTS_ON * state.disturbance_time) * (1.0 - least / size) * state.disturbance


def dcm_ahead(state: GaitState, time: float) -> complex:
    """Return where a push will have moved the DCM within a time (s), a ground point, m."""
    return state.dcm + lasting_shift(state, time)
