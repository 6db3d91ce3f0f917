"""The state in which a command will act, of a robot that answers late."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin

from wbc.errors import MeasurementError
from wbc.estimation.estimate import Estimate
from wbc.estimation.estimator import Estimator
from wbc.estimation.truth import GroundTruthEstimator
from wbc.measurement import Measurement
from wbc.robot import Robot
from wbc.state import State

_LONGEST = 0.05  # s; beyond that a prediction by planned accelerations is a guess


class LatencyCompensation:
    """Predicts an estimator's state over the latency of the robot.

    A command that answers to a reading acts L = k dt after the instant that the reading shows:
    sensors, wire and motors take that long. Until then the robot does what the last k commands,
    which are on their way, were to bring about. With their accelerations a₁ … a_k, the oldest
    first, the state in which the command will act is

        v⁺ = v + dt Σ aᵢ,   q⁺ = q ⊕ (k dt v + dt² Σ (k − i + ½) aᵢ).

    It is the predictor of Smith ("Closer control of loops with dead time", 1957), with the
    robot's model as the controller states it. Contacts, loads and wrenches stay those of the
    reading.

    Args:
        estimator: estimates the state that a reading shows.
        robot: the robot.
        dt: control period, s.
        latency: L beyond that of an ideal robot, whose command acts at once and shows in the next
            reading; s. A function is asked every period, for a latency that is being measured;
            the prediction follows it by one period at a time.

    Attributes:
        robot, dt: as given.

    Raises:
        MeasurementError: a latency, given or returned, that is negative or longer than 0.05 s.
    """

    def __init__(
        self,
        estimator: Estimator | GroundTruthEstimator,
        robot: Robot,
        dt: float = 0.002,
        *,
        latency: float | Callable[[], float],
    ) -> None:
        self.robot, self.dt = robot, dt
        self._estimator, self._latency = estimator, latency
        depth = math.ceil(_LONGEST / dt) + 1
        self._planned: deque[np.ndarray] = deque(maxlen=depth + 1)
        self._periods = self._wanted_periods()

    def __repr__(self) -> str:
        return f"LatencyCompensation({self._estimator!r}, {1e3 * self.latency:g} ms)"

    @property
    def latency(self) -> float:
        """The latency over which the state is predicted, s: whole control periods."""
        return self._periods * self.dt

    def reset(self, state: State) -> None:
        """Start anew at a known state, at rest.

        Raises:
            StateError: see `Estimator.reset`.
        """
        self._planned.clear()
        self._periods = self._wanted_periods()
        self._estimator.reset(state)

    def update(
        self, measurement: Measurement, *, acceleration: np.ndarray | None = None
    ) -> Estimate:
        """Return the estimate, its state as the command of this period will find it.

        Args:
            measurement: readings of the sensors.
            acceleration: (nv,) what the last command was to bring about, m/s² and rad/s²; None
                for nothing.

        Raises:
            MeasurementError: see `Estimator.update` and the class.
        """
        wanted, k = self._wanted_periods(), self._periods
        self._periods = k = k + (wanted > k) - (wanted < k)
        planned, nv = self._planned, self.robot.nv
        planned.append(np.zeros(nv) if acceleration is None else acceleration)
        shown = planned[-1 - k] if k < len(planned) else None
        estimate = self._estimator.update(measurement, acceleration=shown)
        if not k:
            return estimate
        pending = np.array(list(planned)[-k:])
        q, v, dt = estimate.state.q, estimate.state.v, self.dt
        weights = np.arange(len(pending), 0, -1) - 0.5
        step = k * dt * v + dt * dt * (weights @ pending)
        q = pin.integrate(self.robot.model, q, step)
        return replace(estimate, state=State(q, v + dt * pending.sum(axis=0)))

    def _wanted_periods(self) -> int:
        latency = self._latency() if callable(self._latency) else self._latency
        if not 0.0 <= latency <= _LONGEST:
            raise MeasurementError(
                f"LatencyCompensation: latency = {latency} s must be between 0 and {_LONGEST} s; "
                "a robot that answers later cannot be balanced"
            )
        return round(latency / self.dt)
