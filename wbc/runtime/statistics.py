"""Statistics of a run, collected while it goes on."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from wbc.command import Command, Status
from wbc.geometry.planar import wrap_angle
from wbc.robot import Robot
from wbc.robot.attitude import heading
from wbc.runtime.clock import Clock
from wbc.runtime.report import Report
from wbc.state import State
from wbc.telemetry import Telemetry

_TRAIL = 0.1  # s between the points of the trail
_CYCLE = 1.6  # s: the sway of a gait cycle is averaged out of the path over the ground
_MOVING = 0.03  # m/s: slower than this is standing
_CRUISE = 0.8  # share of the fastest speed that counts as cruise


@dataclass(frozen=True, slots=True)
class Progress:
    """The values of a progress line.

    Attributes:
        time: plant time, s.
        duration: of the whole run, s.
        speed: of the last second, m/s.
        dcm_error: m.
        tick_us: median of the recent ticks, µs.
    """

    time: float
    duration: float
    speed: float
    dcm_error: float
    tick_us: float


class RunStatistics:
    """Collects the statistics of a run; its arrays are allocated before the run starts.

    Args:
        robot: the robot.
        start: true state at the start.
        ticks: how many there will be at the most.
    """

    def __init__(self, robot: Robot, start: State, ticks: int) -> None:
        self.robot = robot
        self.ground = float(start.q[2] - robot.q_nominal[2])
        self._tick = np.zeros(ticks)
        self._estimate = np.zeros(ticks)
        self._error = np.zeros(ticks)
        self._count = 0
        self._start_time: float | None = None
        self._time = 0.0
        self._failures = self._steps = 0
        self._explanation = ""
        self._effort = np.zeros(robot.na)
        self._lowest, self._highest = np.full(robot.na, np.inf), np.full(robot.na, -np.inf)
        self._fell_at: float | None = None
        self._diverged = False
        self._early = ""
        self._truth = start
        self._heading = self._yaw = heading(robot, start)
        self._turned = 0.0
        self._trail = [start.q[:2].copy()]
        self._wall = time.perf_counter()

    @property
    def empty(self) -> bool:
        """Whether no tick has been recorded yet."""
        return self._count == 0

    def record(
        self,
        now: float,
        estimator_time: float,
        controller_time: float,
        command: Command,
        truth: State,
        telemetry: Telemetry,
    ) -> None:
        """Record one tick.

        Args:
            now: plant time, s.
            estimator_time: time that the estimator took, s.
            controller_time: time that the controller took, s.
            command: of the tick.
            truth: the true state after it; the estimated one if the truth is unknown.
            telemetry: what the controller tells.
        """
        k = min(self._count, self._tick.size - 1)
        if self._start_time is None:
            self._start_time = now
        self._time = now - self._start_time
        self._tick[k], self._estimate[k] = controller_time, estimator_time
        self._error[k] = telemetry.dcm_error
        self._steps = telemetry.steps
        self._count += 1
        if command.status is not Status.OK:
            self._failures += 1
            self._explanation = self._explanation or command.explanation
        # What is beyond the limits follows from the extremes, once, at the end.
        q = truth.q[7:]
        np.maximum(self._effort, np.abs(command.tau), out=self._effort)
        np.minimum(self._lowest, q, out=self._lowest)
        np.maximum(self._highest, q, out=self._highest)
        self._truth = truth
        if self._time >= len(self._trail) * _TRAIL:
            self._trail.append(truth.q[:2].copy())
            self._record_turn()

    def _record_turn(self) -> None:
        yaw = heading(self.robot, self._truth)
        self._turned += wrap_angle(yaw - self._yaw)
        self._yaw = yaw

    def fell(self, at: float, why: str) -> None:
        """Record that the robot fell.

        Args:
            at: plant time, s.
            why: the reason.
        """
        self._fell_at, self._early = at, why

    def diverged(self, why: str) -> None:
        """Record that the simulated physics diverged in the tick that follows the last recorded."""
        self._diverged, self._early = True, why

    def stopped(self, why: str) -> None:
        """Record why the run ended before its time."""
        self._early = why

    def progress(self, now: float, duration: float) -> Progress:
        """Return what a progress line shows."""
        k = self._count
        back = self._trail[-min(11, len(self._trail))]
        span = max(min(10, len(self._trail) - 1), 1) * _TRAIL
        return Progress(
            now,
            duration,
            float(np.linalg.norm(self._truth.q[:2] - back)) / span,
            float(self._error[k - 1]),
            1e6 * float(np.median(self._tick[max(0, k - 50) : k])),
        )

    def report(self, clock: Clock | None) -> Report:
        """Return the report; `clock` is that of a run in real time."""
        wall = time.perf_counter() - self._wall
        robot = self.robot
        n = min(self._count, self._tick.size)
        tick, errors = 1e6 * self._tick[:n], self._error[:n]
        errors = errors[np.isfinite(errors)]
        self._record_turn()
        here = self._truth.q[:2]
        distance, mean, cruise = _distance_and_speeds(np.array([*self._trail, here]))
        c, s = np.cos(self._heading), np.sin(self._heading)
        dx, dy = here - self._trail[0]
        late = clock.lateness if clock is not None else np.zeros(1)
        return Report(
            robot=robot.name,
            survived=not self._early,
            fell_at_s=self._fell_at,
            fell_why=self._early,
            diverged=self._diverged,
            duration_s=self._time,
            steps=self._steps,
            distance_m=distance,
            displacement_m=(float(c * dx + s * dy), float(c * dy - s * dx)),
            turned_rad=self._turned,
            mean_speed_m_s=mean,
            cruise_speed_m_s=cruise,
            dcm_error_rms_mm=1e3 * float(np.sqrt(np.mean(errors**2))) if errors.size else None,
            torque_peak_ratio=float((self._effort / robot.tau_max).max()),
            torque_excess_nm=max(float((self._effort - robot.tau_max).max()), 0.0),
            joint_limit_excess_rad=max(
                float((robot.q_min - self._lowest).max()),
                float((self._highest - robot.q_max).max()),
                0.0,
            ),
            qp_failures=self._failures,
            explanation=self._explanation,
            tick_p50_us=float(np.percentile(tick, 50)),
            tick_p99_us=float(np.percentile(tick, 99)),
            tick_max_us=float(tick.max()),
            estimator_p50_us=1e6 * float(np.median(self._estimate[:n])),
            real_time_factor=self._time / wall if wall > 0.0 else 0.0,
            overruns=clock.overruns if clock is not None else 0,
            lateness_p99_us=1e6 * float(np.percentile(late, 99)),
        )


def _distance_and_speeds(trail: np.ndarray) -> tuple[float, float, float]:
    """Return distance, m, mean speed while moving and cruise speed, m/s; sway is averaged out.

    Args:
        trail: (n, 2) positions, `_TRAIL` s apart.
    """
    width = round(_CYCLE / _TRAIL)
    padded = np.pad(trail, ((width // 2, width // 2), (0, 0)), mode="edge")
    sums = np.cumsum(np.vstack((np.zeros(2), padded)), axis=0)
    smooth = np.vstack((trail[:1], (sums[width:] - sums[:-width]) / width, trail[-1:]))
    strides = np.linalg.norm(np.diff(smooth, axis=0), axis=1)
    moving = strides > _MOVING * _TRAIL
    # A robot that stands sways a little all the time, which is no distance.
    net = float(np.linalg.norm(trail[-1] - trail[0]))
    distance = max(float(strides[moving].sum()), net)
    if not moving.any():
        return distance, 0.0, 0.0
    speeds = strides[moving] / _TRAIL
    # Starts and stops take most of a short walk: its cruise speed is that of its fastest part.
    cruise = float(np.median(speeds[speeds >= _CRUISE * speeds.max()]))
    return distance, float(speeds.mean()), cruise
