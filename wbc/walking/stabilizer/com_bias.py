"""How far the estimated centre of mass is off, found from what the soles feel."""

from __future__ import annotations

_TIME = 1.5  # s over which is averaged
_FIRST = 0.5  # s of readings that count for nothing against those before
_MOST = 0.03  # m


class ComBiasEstimator:
    """Constant error of the estimated CoM over the soles, on the ground, m.

    An accelerometer that is off by b tilts the estimate by b/g, and the CoM with it. At rest the
    centre of pressure is under the true CoM, and for the pendulum always at `c − c̈ / ω²`; so what
    is left of

        ĉ − c̈ / ω² − cop

    over a long while is the error of ĉ. The mean over the first readings goes over into a
    low-pass of 1.5 s (what the integral term of Caron et al., Stair climbing stabilization of
    the HRP-4 humanoid robot, ICRA 2019, removes by the way of the DCM).

    Args:
        omega: natural frequency ω, 1/s.

    Attributes:
        value: x + iy, m, in the axes of what `update` is given.
    """

    def __init__(self, omega: float) -> None:
        self._omega = omega
        self.value = 0j
        self._since = 0.0

    def update(self, dt: float, com: complex, acceleration: complex, cop: complex) -> None:
        """Take in one reading.

        Args:
            dt: since the last, s.
            com: as estimated, m.
            acceleration: of the CoM, as it is on average, m/s²: that of its reference.
            cop: measured, m.
        """
        self._since += dt
        now = com - acceleration / (self._omega * self._omega) - cop
        if abs(now) > _MOST:  # a push, not a bias
            now *= _MOST / abs(now)
        share = dt / min(_TIME, _FIRST + self._since)
        self.value += share * (now - self.value)
