"""Statistics of a run, collected while it is running."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from wbc.command import Status
from wbc.robot import Robot
from wbc.robot.attitude import heading
from wbc.runtime.clock import Clock
from wbc.runtime.report import Report
from wbc.runtime.tick import Tick
from wbc.state import State

_TRAIL = 0.1  # s between the points of the trail
_CYCLE = 1.6  # s: the sway of a gait cycle is averaged out of the path over the ground
_MOVING = 0.03  # m/s: slower than this is standing
_CRUISE = 0.8  # share of the fastest speed that counts as cruise


@dataclass(frozen=True, slots=True)
class Progress:
    """The values of a progress line.

    Attributes:
        time: plant time, s.
        duration: duration of the whole run, s.
        speed: mean speed over the last second, m/s.
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
        start_time: plant time at the start, s.
        ticks: largest number of ticks.
    """

    def __init__(self, robot: Robot, start: State, start_time: float, ticks: int) -> None:
        self.robot = robot
        self.ground = float(start.q[2] - robot.q_nominal[2])
        self._controller_time, self._estimator_time, self._dcm_error = np.zeros((3, ticks))
        self._count = 0
        self._start_time = start_time
        self._tick: Tick | None = None
        self._state = start
        self._failures = 0
        self._explanation = ""
        self._effort = np.zeros(robot.na)
        self._lowest, self._highest = np.full(robot.na, np.inf), np.full(robot.na, -np.inf)
        self._end_reason = ""
        self._fell_at: float | None = None
        self._falling_at: float | None = None
        self._diverged = False
        self._trail = [self._planar_pose()]
        self._wall = time.perf_counter()

    @property
    def empty(self) -> bool:
        """Whether no tick has been recorded yet."""
        return self._tick is None

    @property
    def falling(self) -> bool:
        """Whether the controller has found a fall unavoidable."""
        return self._falling_at is not None

    def record(self, tick: Tick, state: State) -> None:
        """Record one tick.

        Args:
            tick: the tick.
            state: the true state after it; the estimated one if the truth is unknown.
        """
        k = min(self._count, self._dcm_error.size - 1)
        self._count = k + 1
        self._tick, self._state = tick, state
        self._controller_time[k] = tick.controller_time
        self._estimator_time[k] = tick.estimator_time
        self._dcm_error[k] = tick.telemetry.dcm_error
        if self._falling_at is None and tick.telemetry.phase == "falling":
            self._falling_at = tick.time
        command = tick.command
        if command.status is not Status.OK:
            self._failures += 1
            self._explanation = self._explanation or command.explanation
        # What is beyond the limits follows from the extremes, once, at the end.
        q = state.q[7:]
        np.maximum(self._effort, np.abs(command.tau), out=self._effort)
        np.minimum(self._lowest, q, out=self._lowest)
        np.maximum(self._highest, q, out=self._highest)
        if tick.time - self._start_time >= len(self._trail) * _TRAIL:
            self._trail.append(self._planar_pose())

    def _planar_pose(self) -> tuple[float, float, float]:
        """Return position, m, and heading, rad, of the base over the ground."""
        x, y = self._state.q[:2].tolist()
        return x, y, heading(self.robot, self._state)

    def end(self, reason: str, *, fell_at: float | None = None, diverged: bool = False) -> None:
        """Record why the run ended before its time.

        Args:
            reason: the reason.
            fell_at: plant time at which the robot fell, s; None if it did not.
            diverged: the simulated physics diverged in the tick after the last recorded one.
        """
        self._end_reason, self._fell_at, self._diverged = reason, fell_at, diverged

    def progress(self, duration: float) -> Progress:
        """Return what a progress line shows of a run of this duration, s."""
        assert self._tick is not None
        k = self._count
        points = min(10, len(self._trail) - 1)
        way = np.subtract(self._state.q[:2], self._trail[-1 - points][:2])
        return Progress(
            self._tick.time,
            duration,
            float(np.linalg.norm(way)) / (max(points, 1) * _TRAIL),
            float(self._dcm_error[k - 1]),
            1e6 * float(np.median(self._controller_time[max(0, k - 50) : k])),
        )

    def report(self, clock: Clock | None, conditions: str) -> Report:
        """Return the report.

        Args:
            clock: clock of a run in real time.
            conditions: conditions of a loop in real time, in one line.
        """
        assert self._tick is not None
        wall = time.perf_counter() - self._wall
        robot, n = self.robot, self._count
        duration = self._tick.time - self._start_time
        controller_time = 1e6 * self._controller_time[:n]
        errors = self._dcm_error[:n][np.isfinite(self._dcm_error[:n])]
        trail = np.array([*self._trail, self._planar_pose()])
        distance, mean, cruise = _distance_and_speeds(trail[:, :2])
        yaw = np.unwrap(trail[:, 2])
        c, s = np.cos(yaw[0]), np.sin(yaw[0])
        dx, dy = trail[-1, :2] - trail[0, :2]
        late = clock.lateness if clock is not None else np.zeros(1)
        return Report(
            robot=robot.name,
            survived=not self._end_reason,
            fell_at_s=self._fell_at,
            fell_why=self._end_reason,
            diverged=self._diverged,
            duration_s=duration,
            steps=self._tick.telemetry.steps,
            distance_m=distance,
            displacement_m=(float(c * dx + s * dy), float(c * dy - s * dx)),
            turned_rad=float(yaw[-1] - yaw[0]),
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
            tick_p50_us=float(np.percentile(controller_time, 50)),
            tick_p99_us=float(np.percentile(controller_time, 99)),
            tick_max_us=float(controller_time.max()),
            estimator_p50_us=1e6 * float(np.median(self._estimator_time[:n])),
            real_time_factor=duration / wall if wall > 0.0 else 0.0,
            overruns=clock.overruns if clock is not None else 0,
            lateness_p99_us=1e6 * float(np.percentile(late, 99)),
            loop_conditions=conditions,
            falling_at_s=self._falling_at,
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
