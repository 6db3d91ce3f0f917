"""Bias of the estimated centre of mass, observed from the measured centre of pressure."""

from __future__ import annotations

from wbc.geometry.planar import planar_rotation

_TIME = 1.5  # s, time constant of the bias
_FIRST = 0.5  # s of readings that the first ones are averaged with
_SMOOTHING = 0.05  # s, time constant of the DCM's rate
_MAX_BIAS = 0.03  # m


class ComBiasEstimator:
    """Constant error of the estimated CoM over the soles, on the ground, m.

    An accelerometer that is off by b tilts the estimate by b/g, and the CoM with it. The linear
    inverted pendulum moves by `ξ̇ = ω (ξ − p)` with the true DCM ξ and centre of pressure p, so

        ξ̂ − ξ̂˙ / ω − p

    is the error of the estimated DCM ξ̂, which is that of the CoM. Both ξ̂ and p pass the same
    low-pass of 0.05 s, so that the rate of ξ̂ is the difference to its low-pass; pushes average
    out in a second low-pass (the integral term of Caron et al., Stair climbing stabilization of
    the HRP-4 humanoid robot, ICRA 2019, removes the same bias by way of the DCM error).

    The bias is estimated at rest and kept while the robot steps: there the pendulum's own model
    error, which does not average to zero over a step, would be taken for a bias.
    """

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start anew, without a known bias."""
        self._bias = 0j  # heading axes, m
        self._elapsed = 0.0
        self._dcm: complex | None = None  # low-passed, world axes
        self._offset = 0j  # low-passed ξ̂ − p, world axes

    def update(
        self,
        dt: float,
        dcm: complex,
        cop: complex | None,
        omega: float,
        heading: float,
    ) -> complex:
        """Take in one reading; returns the bias in world axes, m.

        Args:
            dt: time since the last reading, s.
            dcm: estimated ξ̂, ground point in world axes, m.
            cop: measured p, ground point in world axes, m; None keeps the bias: the robot steps,
                or nothing is measured.
            omega: natural frequency ω, 1/s.
            heading: axes in which the bias is constant, rad.
        """
        to_world = planar_rotation(heading)
        if cop is None:
            self._dcm = None
            return self._bias * to_world
        if self._dcm is None:
            self._dcm, self._offset = dcm, dcm - cop
        share = min(dt / _SMOOTHING, 1.0)
        self._dcm += share * (dcm - self._dcm)
        self._offset += share * (dcm - cop - self._offset)
        error = self._offset - (dcm - self._dcm) / (_SMOOTHING * omega)
        size = abs(error)
        if size > _MAX_BIAS:  # a push, not a bias
            error *= _MAX_BIAS / size
        self._elapsed += dt
        share = dt / min(_TIME, _FIRST + self._elapsed)
        self._bias += share * (error * to_world.conjugate() - self._bias)
        return self._bias * to_world
