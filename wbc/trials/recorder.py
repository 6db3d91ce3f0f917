"""Records the ticks of a trial, and computes its figures from them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wbc.command import Status
from wbc.errors import PhysicsDiverged
from wbc.robot.fall import fall_reason
from wbc.runtime.protocols import TelemetrySource
from wbc.trials.closed_loop import ClosedLoop

_SLOW = 5  # ticks between two samples of what changes slowly, and two checks for a fall


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """How a stretch of a run went.

    Attributes:
        survived: whether it ended as it should.
        fell_at_s: time of the fall since the beginning of the stretch, s; None without a fall.
        reason: why the stretch ended early; else empty.
        crashed: whether it ended with an error of the controller.
    """

    survived: bool = True
    fell_at_s: float | None = None
    reason: str = ""
    crashed: bool = False


@dataclass(frozen=True, slots=True)
class TrialMetrics:
    """TrialMetrics of a stretch of a run; those that cannot be computed are None.

    Attributes:
        duration_s: s.
        steps: touchdowns.
        distance_m: displacement of the base over the ground, m.
        dcm_error_peak_m: largest distance of the DCM from its reference.
        torque_peak: largest |τ| of any motor, as a share of its limit.
        torque_rms_nm: root of the mean over time of the sum over all motors of τ², N·m.
        joint_velocity_peak: largest true |q̇| of any joint, as a share of its limit.
        position_error_rms_m: of the estimated base against the true one.
        velocity_error_rms_m_s: likewise, in world axes.
        tilt_error_rms_rad: angle between the estimated and the true vertical.
        mechanical_power_w: mean over time of Σ |τ q̇| over all motors.
        cost_of_transport: mechanical work over weight and distance; None if it is standing.
        landing_force_peak: largest normal force on a foot, as a share of the weight.
        qp_failures: ticks whose QP had no solution.
        falling_at_s: time at which the controller found a fall unavoidable, s; None if it did not.
    """

    duration_s: float
    steps: int | None
    distance_m: float
    dcm_error_peak_m: float | None
    torque_peak: float
    torque_rms_nm: float
    joint_velocity_peak: float
    position_error_rms_m: float
    velocity_error_rms_m_s: float
    tilt_error_rms_rad: float
    mechanical_power_w: float
    cost_of_transport: float | None
    landing_force_peak: float
    qp_failures: int
    falling_at_s: float | None


class Recorder:
    """Runs a closed loop and records its ticks.

    Args:
        loop: the loop.
    """

    def __init__(self, loop: ClosedLoop) -> None:
        self._loop = loop
        self._count = 0

    def run(
        self, duration: float, before_tick: Callable[[int], None] = lambda _: None
    ) -> RunOutcome:
        """Run for a time or until the robot falls; the figures are those of this stretch.

        Args:
            duration: s.
            before_tick: called before each tick with its number, from 0.
        """
        loop, plant = self._loop, self._loop.plant
        robot = plant.robot
        count = round(duration / plant.dt)
        self._allocate(count)
        source = loop.controller if isinstance(loop.controller, TelemetrySource) else None
        feet = [sole.name for sole in robot.soles]
        self._observe_telemetry(source)
        for k in range(count):
            before_tick(k)
            truth = plant.ground_truth()
            self._q[k], self._v[k] = truth.q, truth.v
            try:
                estimate, command = loop.tick()
            except PhysicsDiverged as error:
                return RunOutcome(False, k * plant.dt, str(error))
            except Exception as error:  # whatever a controller under test may raise
                text = f"{type(error).__name__}: {error}"
                return RunOutcome(False, k * plant.dt, text, crashed=True)
            self._count = k + 1
            self._estimated_q[k] = estimate.state.q[:7]
            self._estimated_v[k] = estimate.state.v[:3]
            self._torque[k] = plant.torque
            forces = plant.foot_forces
            self._load[k] = max(float(forces[name][2]) for name in feet)
            self._failures += command.status is not Status.OK
            if k % _SLOW == _SLOW - 1 or k == count - 1:
                self._observe_telemetry(source)
                reason = fall_reason(robot, plant.ground_truth())
                if reason:
                    return RunOutcome(False, (k + 1) * plant.dt, reason)
        return RunOutcome()

    def _allocate(self, count: int) -> None:
        robot = self._loop.plant.robot
        self._count = self._failures = 0
        self._dcm_error = -math.inf
        self._falling_at: float | None = None
        self._first_steps: int | None = None
        self._last_steps: int | None = None
        self._q = np.empty((count, robot.nq))
        self._v = np.empty((count, robot.nv))
        self._estimated_q = np.empty((count, 7))
        self._estimated_v = np.empty((count, 3))
        self._torque = np.empty((count, robot.na))
        self._load = np.empty(count)

    def _observe_telemetry(self, source: TelemetrySource | None) -> None:
        if source is None:
            return
        telemetry = source.telemetry
        if math.isfinite(telemetry.dcm_error):
            self._dcm_error = max(self._dcm_error, telemetry.dcm_error)
        if telemetry.phase == "falling" and self._falling_at is None:
            self._falling_at = self._count * self._loop.plant.dt
        self._last_steps = telemetry.steps
        if self._first_steps is None:
            self._first_steps = telemetry.steps

    def metrics(self) -> TrialMetrics | None:
        """Return the metrics of the last stretch; None if it had no complete tick."""
        n, robot, dt = self._count, self._loop.plant.robot, self._loop.plant.dt
        if n == 0:
            return None
        q, v = self._q[:n], self._v[:n]
        torque, load = self._torque[:n], self._load[:n]
        joint_velocity = v[:, 6:]
        duration = n * dt
        distance = float(np.linalg.norm(q[-1, :2] - q[0, :2]))
        power = float(np.abs(torque * joint_velocity).sum(axis=1).mean())
        estimated_q, estimated_v = self._estimated_q[:n], self._estimated_v[:n]
        true_axes, axes = _rotations(q[:, 3:7]), _rotations(estimated_q[:, 3:7])
        true_velocity = np.einsum("nij,nj->ni", true_axes, v[:, :3])
        velocity = np.einsum("nij,nj->ni", axes, estimated_v)
        # The third row is the vertical in the base's axes.
        cosine = np.einsum("nj,nj->n", true_axes[:, 2], axes[:, 2])
        tilt = np.arccos(np.clip(cosine, -1.0, 1.0))
        first, last = self._first_steps, self._last_steps
        return TrialMetrics(
            duration_s=duration,
            steps=None if first is None or last is None else last - first,
            distance_m=distance,
            dcm_error_peak_m=self._dcm_error if math.isfinite(self._dcm_error) else None,
            torque_peak=float((np.abs(torque) / robot.tau_max).max()),
            torque_rms_nm=_rms(torque),
            joint_velocity_peak=float((np.abs(joint_velocity) / robot.v_max).max()),
            position_error_rms_m=_rms(estimated_q[:, :3] - q[:, :3]),
            velocity_error_rms_m_s=_rms(velocity - true_velocity),
            tilt_error_rms_rad=_rms(tilt[:, None]),
            mechanical_power_w=power,
            cost_of_transport=power * duration / (robot.weight * distance)
            if distance > _WALKED * duration
            else None,
            landing_force_peak=float(load.max()) / robot.weight,
            qp_failures=self._failures,
            falling_at_s=self._falling_at,
        )


_WALKED = 0.02  # m/s; a robot that is slower stands


def _rms(rows: np.ndarray) -> float:
    """Root of the mean over the rows of the sum of squares."""
    return float(np.sqrt(np.mean(np.sum(rows * rows, axis=1))))


def _rotations(quaternions: np.ndarray) -> np.ndarray:
    """Return rotation matrices, (n, 3, 3), of unit quaternions (x, y, z, w), (n, 4)."""
    x, y, z, w = quaternions.T
    return np.stack(
        [
            1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
            2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
            2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
        ],
        axis=1,
    ).reshape(-1, 3, 3)  # fmt: skip
