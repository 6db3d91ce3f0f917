"""The result of a run in numbers."""

from __future__ import annotations

import json
import textwrap
from dataclasses import asdict, dataclass
from pathlib import Path

from wbc.atomic_file import replacing

_WIDTH = 100  # characters of a line of the table


@dataclass(frozen=True, slots=True)
class Flight:
    """A time in which no sole touched the ground, in truth.

    Attributes:
        duration_s: s.
        take_off_speed_m_s: upward speed of the CoM at take-off, m/s.
        rise_mm: rise of the CoM from take-off to its apex, mm.
        clearance_mm: greatest height of the lower sole's lowest corner over the ground.
        spin: angular momentum about the CoM at take-off, kg·m²/s.
        spin_change: farthest that it got from that in flight, kg·m²/s.
        landing_error_mm: farther of the ways from where a sole left to where it landed.
        push_off_load: largest force on both feet before, as a share of the weight.
        landing_load: likewise within 0.3 s after touchdown.
    """

    duration_s: float
    take_off_speed_m_s: float
    rise_mm: float
    clearance_mm: float
    spin: float
    spin_change: float
    landing_error_mm: float
    push_off_load: float
    landing_load: float

    def __str__(self) -> str:
        return (
            f"{self.duration_s:.2f} s; CoM rose {self.rise_mm:.0f} mm, soles cleared "
            f"{self.clearance_mm:.0f} mm and landed {self.landing_error_mm:.0f} mm off; load "
            f"{self.push_off_load:.1f} / {self.landing_load:.1f} × weight (push-off / landing)"
        )


@dataclass(frozen=True, slots=True)
class Report:
    """The result of `wbc.run`.

    Attributes:
        robot: name of the robot.
        survived: whether the robot did not fall and nothing ended the run early.
        fell_at_s: time of the fall, s; None if the robot did not fall.
        falling_at_s: time at which the controller found a fall unavoidable, s; None if it did not.
        fell_why: reason of the fall or of the early end of the run; else empty.
        diverged: whether the simulated physics diverged; all figures are of the ticks before.
        duration_s: simulated time, s.
        steps: number of touchdowns.
        distance_m: length of the path over the ground while moving, the sway of the gait averaged
            out.
        displacement_m: (forward, left) of the base from its start, in its first heading, m.
        turned_rad: heading change, counted over full turns, rad.
        mean_speed_m_s: distance over time spent walking, starts and stops included, m/s.
        cruise_speed_m_s: median speed, over a gait cycle, while it is at least 80 % of the
            fastest, m/s.
        dcm_error_rms_mm: error of the measured DCM against its plan, mm; None without a plan.
        torque_peak_ratio: largest |τ| / τ_max of any joint.
        torque_excess_nm: largest excess of a commanded torque over its limit, N·m.
        joint_limit_excess_rad: largest excess of a joint over its position limit, rad.
        qp_failures: number of ticks whose QP had no solution.
        explanation: the first failed tick's explanation.
        tick_p50_us: median time of `controller.step`, µs; likewise the 99th percentile and
            the maximum.
        estimator_p50_us: median time of the state estimation, µs.
        real_time_factor: simulated time over wall time.
        overruns: number of real-time ticks that began late by more than a period.
        lateness_p99_us: 99th percentile of how late a real-time tick began, µs.
        loop_conditions: requests of a real-time loop and their results; else empty.
        com_error_rms_mm: error of the true CoM against a motion's reference, relative to the
            soles, in 3D, mm; None if it was not evaluated; likewise the next.
        foot_slip_mm: largest displacement of a loaded sole over the ground, mm.
        targets: number of positions that a motion was to reach with a hand.
        targets_reached: number of them that were reached within 1 cm in the true state.
        target_error_max_mm: largest error at a target, mm.
        notes: remarks of motions on how they went.
        aborted_motions: names of aborted motions; the notes give the reasons.
        flights: periods with both soles off the ground.
    """

    robot: str
    survived: bool
    fell_at_s: float | None
    fell_why: str
    duration_s: float
    steps: int
    distance_m: float
    displacement_m: tuple[float, float]
    turned_rad: float
    mean_speed_m_s: float
    cruise_speed_m_s: float
    dcm_error_rms_mm: float | None
    torque_peak_ratio: float
    torque_excess_nm: float
    joint_limit_excess_rad: float
    qp_failures: int
    explanation: str
    tick_p50_us: float
    tick_p99_us: float
    tick_max_us: float
    estimator_p50_us: float
    real_time_factor: float
    overruns: int
    lateness_p99_us: float
    loop_conditions: str = ""
    diverged: bool = False
    com_error_rms_mm: float | None = None
    foot_slip_mm: float | None = None
    targets: int = 0
    targets_reached: int = 0
    target_error_max_mm: float | None = None
    notes: tuple[str, ...] = ()
    aborted_motions: tuple[str, ...] = ()
    flights: tuple[Flight, ...] = ()
    falling_at_s: float | None = None

    def __repr__(self) -> str:
        return (
            f"Report({self.robot}: {self._result()}; {self.distance_m:.2f} m, {self.steps} steps, "
            f"{self.qp_failures} QP failures, tick {self.tick_p50_us:.0f} µs)"
        )

    def to_json(self) -> str:
        """Return all fields as a JSON object."""
        return json.dumps(asdict(self), indent=2)

    def save(self, path: str | Path) -> None:
        """Write `to_json` to a file, which stays what it was if that fails."""
        with replacing(Path(path)) as file:
            file.write_text(self.to_json() + "\n", encoding="utf-8")

    def _result(self) -> str:
        if self.survived:
            aborted = f", but GAVE UP: {', '.join(self.aborted_motions)}"
            return f"survived {self.duration_s:.1f} s" + (aborted if self.aborted_motions else "")
        if self.fell_at_s is not None:
            return f"FELL at {self.fell_at_s:.2f} s: {self.fell_why}{self._foreseen()}"
        if self.diverged:
            return f"NO RESULT: {self.fell_why}; the figures are of the time before"
        return f"ended early at {self.duration_s:.2f} s: {self.fell_why}"

    def _foreseen(self) -> str:
        if self.fell_at_s is None or self.falling_at_s is None:
            return ""
        return f" (foreseen {self.fell_at_s - self.falling_at_s:.2f} s before)"

    def table(self) -> str:
        """Return the result as a table for people."""
        fate = self._result()
        forward, left = self.displacement_m
        why = f"  ({self.explanation})" if self.explanation else ""
        rows = [
            ("result", fate),
            ("steps", f"{self.steps}"),
            (
                "distance",
                f"{self.distance_m:.2f} m  (forward {forward:+.2f} m, left {left:+.2f} m, "
                f"turned {self.turned_rad * 57.29578:+.0f}°)",
            ),
            (
                "speed",
                f"{self.mean_speed_m_s:.2f} m/s mean, {self.cruise_speed_m_s:.2f} m/s cruise",
            ),
            *_rms("DCM tracking error", self.dcm_error_rms_mm, "rms"),
            ("peak torque", f"{100.0 * self.torque_peak_ratio:.0f} % of the limit"),
            ("beyond joint limits", f"{self.joint_limit_excess_rad:.1e} rad"),
            ("QP failures", f"{self.qp_failures}{why}"),
            (
                "tick time",
                f"{self.tick_p50_us:.0f} / {self.tick_p99_us:.0f} / {self.tick_max_us:.0f} µs"
                "  (median / 99 % / max)",
            ),
            ("estimator time", f"{self.estimator_p50_us:.0f} µs  (median)"),
            ("speed of simulation", f"{self.real_time_factor:.2f} × real time"),
        ]
        if self.lateness_p99_us > 0.0:
            late = f"99 % less than {self.lateness_p99_us:.0f} µs late"
            rows.append(("real-time ticks", f"{self.overruns} overruns, {late}"))
        rows += self._judged()
        width = max(len(name) for name, _ in rows)
        head = f"{self.robot}\n" + "─" * (width + 40)
        return "\n".join([head, *(_row(name, value, width) for name, value in rows)])

    def _judged(self) -> list[tuple[str, str]]:
        rows = _rms("CoM tracking error", self.com_error_rms_mm, "rms (true)")
        if self.foot_slip_mm is not None:
            rows.append(("foot slip", f"{self.foot_slip_mm:.1f} mm"))
        if self.targets:
            reached = f"{self.targets_reached} of {self.targets} within 1 cm"
            rows.append(("targets", f"{reached}, worst {self.target_error_max_mm or 0.0:.1f} mm"))
        rows += [("flight", str(flight)) for flight in self.flights]
        rows += [("note", note) for note in self.notes]
        return rows


def _rms(name: str, error: float | None, what: str) -> list[tuple[str, str]]:
    return [] if error is None else [(name, f"{error:.1f} mm {what}")]


def _row(name: str, value: str, width: int) -> str:
    """Return a line of the table; a long text is wrapped below itself."""
    blank = " " * (width + 2)
    return textwrap.fill(
        value, _WIDTH, initial_indent=f"{name:<{width}}  ", subsequent_indent=blank
    )
