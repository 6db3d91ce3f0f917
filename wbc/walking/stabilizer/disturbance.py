"""Disturbance observer: the force of a push, seen in the DCM before the DCM has moved far."""

from __future__ import annotations

from wbc.gait import GaitState

_TIME_CONSTANT = 0.01  # s, of the low-pass filter
_SETTLING = 0.1  # s after a reset in which the estimate itself moves
_NO_PUSH = 0.5  # m/s by which noise and settling seem to move the DCM
_FAST = 4.0  # times as much in fast walking, where limits keep the CoM from its reference


class DisturbanceObserver:
    """Estimates how fast an unknown force moves the DCM.

    A force F on the robot adds F / (m ω) to what ZMP p and pivot offset δ do to the DCM,

        d = ξ̇ − ω (ξ − p − δ),

    with ξ̇ = ċ + c̈/ω from the velocity of the CoM alone: its position is corrected at once when a
    sole slips. It is low-pass filtered because c̈ is a difference of estimates (a disturbance
    observer after K. Ohnishi, M. Shibata, T. Murakami, Motion control for advanced mechatronics,
    1996).

    Args:
        dt: time between two updates, s.

    Attributes:
        rate: d, ground vector, m/s.
    """

    def __init__(self, dt: float) -> None:
        self._dt, self._share = dt, min(dt / _TIME_CONSTANT, 1.0)
        self.rate = 0j
        self._before: complex | None = None
        self._expected = 0j
        self._age = 0.0

    def reset(self) -> None:
        """Start anew, without a disturbance."""
        self.rate, self._expected, self._before = 0j, 0j, None
        self._age = 0.0

    def update(self, velocity: complex, omega: float) -> complex:
        """Return the rate of the disturbance, m/s.

        Args:
            velocity: estimated ċ of this tick, m/s.
            omega: natural frequency ω, 1/s.
        """
        before, self._before = self._before, velocity
        self._age += self._dt
        if before is not None and self._age > _SETTLING:
            rate = velocity + (velocity - before) / (omega * self._dt) - self._expected
            self.rate += self._share * (rate - self.rate)
        return self.rate

    def expect(self, rate: complex) -> None:
        """Set the `ω (ξ − p − δ)` that the command of this tick leads to, m/s."""
        self._expected = rate


def lasting_rate(state: GaitState) -> complex:
    """Return the rate at which a push moves the DCM, without noise and settling, m/s."""
    rate = state.disturbance
    size, least = abs(rate), _least_size(state)
    return (1.0 - least / size) * rate if size > least else 0j


def _least_size(state: GaitState) -> float:
    """Size up to which a disturbance is noise and settling, m/s."""
    return _NO_PUSH * (1.0 + (_FAST - 1.0) * state.fast_share)


def dcm_ahead(state: GaitState, time: float) -> complex:
    """Return where a push that lasts on for a time (s) will have moved the DCM, a ground point, m.

    The motion `ω (ξ − p)` of the pendulum itself is not in it.
    """
    return state.dcm + time * lasting_rate(state)


def is_pushed(state: GaitState) -> bool:
    """Return whether a push is seen to last, or the present step catches one."""
    return state.is_quick or abs(state.disturbance) > _least_size(state)
