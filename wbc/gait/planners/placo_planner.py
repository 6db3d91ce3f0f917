"""Planner with placo's walk pattern, which a process of its own computes."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from itertools import chain, pairwise
from typing import Any

from wbc.gait.phase import SWING
from wbc.gait.planners.dcm import DcmReference, ZmpSegment, dcm_after, solve_dcm
from wbc.gait.planners.dcm_planner import DcmPlanner
from wbc.gait.planners.placo_program import ComPlan, ComRequest
from wbc.gait.planners.planner import PlanFailed, StepPlan
from wbc.gait.state import GaitCommand, GaitState
from wbc.geometry.planar import Placement
from wbc.geometry.polygon import convex_hull, sole_corners
from wbc.process.child import ChildProcess
from wbc.robot import Robot

_INTERVAL = 0.04  # s between two nodes of the plan
_SETTLING = 0.4  # s at rest at the end of the plan
_DELAY = 0.03  # s from the request to the use of its plan; placo takes some milliseconds
_TIMEOUT = 10.0  # s, until a process that does not reply counts as dead
_SOLE_SHARE = 0.8  # of the sole that the plan uses; the rest is the feedback's


class _AnalyticPath:
    """The analytic DCM over a ZMP, from the time of a request on."""

    def __init__(self, segments: list[ZmpSegment], omega: float) -> None:
        self._omega = omega
        self._parts: list[tuple[float, ZmpSegment, complex]] = []
        time, dcm = 0.0, solve_dcm(segments, omega).dcm
        for segment in segments:
            self._parts.append((time, segment, dcm))
            dcm = dcm_after(segment, dcm, segment.duration, omega)
            time += segment.duration

    def at(self, time: float) -> tuple[complex, complex]:
        """DCM and ZMP at a time (s) within the path, m."""
        begin, (start, end, duration), dcm = next(
            part for part in reversed(self._parts) if part[0] <= time
        )
        time = min(time - begin, duration)
        share = time / duration if duration > 0.0 else 1.0
        segment = ZmpSegment(start, end, duration)
        return dcm_after(segment, dcm, time, self._omega), start + share * (end - start)


@dataclass(slots=True)
class _Pattern:
    """A plan that was asked for, and what it differs from.

    Attributes:
        request: what was asked.
        path: the analytic plan at that time.
        age: time since then, s.
        plan: the answer; None while there is none.
    """

    request: ComRequest
    path: _AnalyticPath
    age: float = 0.0
    plan: ComPlan | None = None

    def differences(self) -> tuple[complex, complex]:
        """By how much DCM and ZMP of the plan differ from the analytic ones now, m."""
        plan, omega = self.plan, self.request.omega
        if plan is None or self.age >= plan.duration:
            return 0j, 0j
        com, velocity, acceleration = plan.at(self.age)
        dcm, zmp = self.path.at(self.age)
        return com + velocity / omega - dcm, com - acceleration / omega**2 - zmp


class PlacoPlanner(DcmPlanner):
    """Plans the centre of mass with placo over the footsteps of the `DcmPlanner`.

    At the beginning of each phase a process is asked for the centre of mass from its planned state
    on, over the next footsteps to rest (`plan_com`). The plan is followed from 30 ms after that,
    whenever it was ready, so that runs are reproducible; a process that takes longer delays the
    control loop. Its DCM differs from the analytic one by y, its ZMP by d, which obey the linear
    inverted pendulum as well, `ẏ = ω (y − d)`. A foot that lands elsewhere changes the analytic
    plan at once; the difference stays until the next phase.

    Standing, and the quick steps after a push, are the analytic planner's.

    Args:
        robot: the robot, for the size of its soles.

    Attributes:
        failures: how often there was no plan. The analytic one then takes its place until the next
            phase; a `PlanFailed` warning says so once.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__()
        self._half_length = _SOLE_SHARE * min(sole.half_length for sole in robot.soles)
        self._half_width = _SOLE_SHARE * min(sole.half_width for sole in robot.soles)
        self.failures = 0
        self._com = 0j  # planned, m
        self._followed: _Pattern | None = None
        self._pending: _Pattern | None = None
        self._dcm_difference = self._zmp_difference = 0j
        self._process: ChildProcess | None = _start()
        self._asked = False  # the process has the request of the pending pattern

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_process": None, "_asked": False}

    def reset(self, state: GaitState) -> None:
        """See `Planner.reset`."""
        super().reset(state)
        self._forget()

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """See `Planner.update`."""
        plan = super().update(state, command, dt)
        if state.at_rest or state.is_quick:
            self._forget()
            self._com = state.standing_point if state.at_rest else state.com
            return plan
        for pattern in (self._followed, self._pending):
            if pattern is not None:
                pattern.age += dt
        if state.time == 0.0:
            self._request(state)
        elif self._pending is not None and self._pending.age >= _DELAY - 0.5 * dt:
            self._followed, self._pending = self._answered(self._pending), None
        if self._followed is not None:
            self._dcm_difference, self._zmp_difference = self._followed.differences()
        self._com += dt * state.gait.omega * (self.reference(state).dcm - self._com)
        return plan

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """See `Planner.reference`."""
        analytic = super().reference(state, landing)
        if self._followed is None:
            return analytic
        omega = state.gait.omega
        dcm, zmp = analytic.dcm + self._dcm_difference, analytic.zmp + self._zmp_difference
        drift = analytic.dcm_velocity - omega * (analytic.dcm - analytic.zmp)
        return DcmReference(dcm, omega * (dcm - zmp) + drift, zmp)

    def _forget(self) -> None:
        """Return to the analytic plan."""
        self._followed = self._pending = None
        self._dcm_difference = self._zmp_difference = 0j

    def _request(self, state: GaitState) -> None:
        """Ask for a plan from the planned state on."""
        if self._pending is not None:
            self._answered(self._pending)  # one reply for each request
        omega, reference = state.gait.omega, self.reference(state)
        segments = self._present_zmp(state)
        if not state.stopping:
            segments += self._later_zmp(state, state.stance)
        zmp, polygons = self._nodes(state, segments)
        request = ComRequest(
            omega,
            _INTERVAL,
            self._com,
            omega * (reference.dcm - self._com),
            omega * omega * (self._com - reference.zmp),
            zmp,
            polygons,
        )
        self._pending, self._asked = _Pattern(request, _AnalyticPath(segments, omega)), False
        self._ask(request)

    def _ask(self, request: ComRequest) -> None:
        if self._process is None:
            self._process = _start()
        self._process.send(request)
        self._asked = True

    def _answered(self, pattern: _Pattern) -> _Pattern | None:
        """Return the pattern with the answer of the process; None if there is no plan."""
        if not self._asked:  # a copy has a process of its own
            self._ask(pattern.request)
        assert self._process is not None
        reply = self._process.receive(_TIMEOUT)
        if not reply:
            self._process = None
        pattern.plan = reply.get("plan")
        if pattern.plan is not None:
            return pattern
        self.failures += 1
        if self.failures == 1:
            why = "found no plan" if reply else "has died, or does not reply"
            warnings.warn(
                f"the process of the placo planner {why}: the analytic DCM plan takes its place "
                "until the next phase (PlacoPlanner.failures counts how often)",
                PlanFailed,
                stacklevel=3,
            )
        return None

    def _nodes(
        self, state: GaitState, segments: list[ZmpSegment]
    ) -> tuple[tuple[complex, ...], tuple[tuple[complex, ...], ...]]:
        """Return the wanted ZMP and the support polygon at each node of the plan."""
        polygons = [self._polygon(soles) for soles in self._soles(state, len(segments))]
        end = sum(segment.duration for segment in segments)
        zmp, supports = [], []
        index, begin = 0, 0.0
        for node in range(1, math.ceil((end + _SETTLING) / _INTERVAL) + 1):
            time = node * _INTERVAL
            while index < len(segments) - 1 and time >= begin + segments[index].duration:
                begin += segments[index].duration
                index += 1
            start, goal, duration = segments[index]
            share = min((time - begin) / duration, 1.0) if duration > 0.0 else 1.0
            zmp.append(start + share * (goal - start))
            supports.append(polygons[index])
        return tuple(zmp), tuple(supports)

    def _soles(self, state: GaitState, count: int) -> list[list[Placement]]:
        """Return the soles on the ground in each segment of the planned ZMP."""
        stance = state.stance
        both = [stance, state.other_foot]
        if state.stopping:
            return [both] * count
        feet = [stance, *(step.placement for step in self._planned_steps(state))]
        later: list[list[Placement]] = []
        for foot, step in pairwise(feet):
            later += [[foot], [foot, step]]
        if state.phase is SWING:
            return later[:count]
        return [both] * (count - len(later)) + later

    def _polygon(self, soles: list[Placement]) -> tuple[complex, ...]:
        corners = [sole_corners(sole, self._half_length, self._half_width) for sole in soles]
        return tuple(convex_hull(chain.from_iterable(corners)))


def _start() -> ChildProcess:
    process = ChildProcess("wbc.gait.planners.placo_worker", title="the planner")
    process.send(None)  # the first message is the configuration
    return process
