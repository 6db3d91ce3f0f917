"""Planner by model-predictive control: ZMP and footsteps from the DCM as it is."""

from __future__ import annotations

import math
import warnings
from itertools import pairwise

import numpy as np

from wbc.gait.footsteps import lateral_sign, other_side
from wbc.gait.parameters import GaitParameters
from wbc.gait.phase import SWING, TRANSFER, Phase
from wbc.gait.planners.dcm import DcmReference
from wbc.gait.planners.dcm_planner import PREVIEW_STEPS, DcmPlanner
from wbc.gait.planners.planner import PlanFailed, StepPlan
from wbc.gait.planners.zmp_step_mpc import NODES, ZmpStepMpc, ZmpStepPlan
from wbc.gait.state import GaitCommand, GaitState
from wbc.gait.swing_foot import SwingFoot
from wbc.geometry.planar import Placement, planar_rotation, wrap_angle
from wbc.robot import Robot

_PERIOD = 0.02  # s between two solutions
_SOLE_SHARE = 1.0  # of the sole that the plan uses; the rest is the feedback's
_FIXED = np.zeros((2, 2 * PREVIEW_STEPS))


class MpcPlanner(DcmPlanner):
    """Plans ZMP and footsteps that lead the DCM as it is measured back to the analytic plan.

    Footsteps at a velocity, durations and the DCM that leads over them are those of the
    `DcmPlanner`. Every 20 ms, and whenever phase, gait or duration change, `ZmpStepMpc` finds how
    the ZMP within the soles and the next three footsteps within reach have to differ from that.
    In between, the difference y of the DCM follows that of the ZMP, d, by the linear inverted
    pendulum, `ẏ = ω (y − d)`. What no ZMP and footstep of the plan catch is left to the stabilizer
    as an error, which then moves or shortens the step.

    Given footsteps are not moved. Standing and coming to rest are the analytic planner's.

    Args:
        robot: the robot, for the size of its soles.

    Attributes:
        failures: how often no solution was found. The analytic plan then takes its place until the
            next one is; a `PlanFailed` warning says so once.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__()
        half_length = min(sole.half_length for sole in robot.soles)
        half_width = min(sole.half_width for sole in robot.soles)
        self._half_size = _SOLE_SHARE * complex(half_length, half_width)
        self._program = ZmpStepMpc(PREVIEW_STEPS)
        self.failures = 0
        self._solution: ZmpStepPlan | None = None
        self._solved_for: tuple[Phase, int, GaitParameters, float] | None = None
        self._age = math.inf  # of the solution, s
        # Differences from the analytic plan in the axes of the support sole, m.
        self._dcm: complex = 0j
        self._zmp: complex = 0j
        self._displacement: complex = 0j  # of the landing place

    def reset(self, state: GaitState) -> None:
        """See `Planner.reset`."""
        super().reset(state)
        self._forget()

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """See `Planner.update`."""
        plan = super().update(state, command, dt)
        if state.at_rest or state.stopping:
            self._forget()
            return plan
        self._age += dt
        if self._age >= _PERIOD - 0.5 * dt or not self._is_current(state):
            self._solve(state)
        elif self._solution is not None:
            omega = state.gait.omega
            self._dcm = (self._dcm - self._zmp) * math.exp(omega * dt) + self._zmp
            self._zmp = self._zmp_at(self._age, omega)
        if plan.landing is not None:
            plan.landing = self._displaced_landing(state)
        return plan

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """See `Planner.reference`."""
        if self._solution is None:
            return super().reference(state, landing)
        if landing is None and state.phase is SWING:
            landing = self._displaced_landing(state)
        analytic = super().reference(state, landing)
        if not self._is_current(state):
            return analytic
        turn = planar_rotation(state.stance.yaw)
        omega, zmp = state.gait.omega, analytic.zmp + self._zmp * turn
        dcm = analytic.dcm + self._dcm * turn
        drift = analytic.dcm_velocity - omega * (analytic.dcm - analytic.zmp)
        return DcmReference(dcm, omega * (dcm - zmp) + drift, zmp)

    def _forget(self) -> None:
        self._solution = self._solved_for = None
        self._age = math.inf
        self._dcm = self._zmp = self._displacement = 0j

    def _is_current(self, state: GaitState) -> bool:
        solved = self._solved_for
        return (
            solved is not None
            and solved[0] is state.phase
            and solved[1] == state.steps
            and solved[2] is state.gait
            and solved[3] == state.duration
        )

    def _displaced_landing(self, state: GaitState) -> Placement:
        point, yaw, height = self._relative_landing
        landing = state.stance.compose(Placement(point + self._displacement, yaw, height))
        return landing if self._follows_given else state.on_slope(landing)

    def _zmp_at(self, age: float, omega: float) -> complex:
        """Difference of the ZMP at a time (s) after the solution, m."""
        assert self._solution is not None
        node = age / self._program.interval(omega)
        k = min(int(node), NODES - 2)
        nodes = self._solution.zmp
        start, end = complex(nodes[k]), complex(nodes[k + 1])
        return start + (node - k) * (end - start)

    def _solve(self, state: GaitState) -> None:
        stance = state.stance
        analytic = super().reference(state).dcm
        error = (state.dcm - state.dcm_offset - analytic) * planar_rotation(-stance.yaw)
        steps = self._planned_steps(state)
        starts, transfers = self._transfers(state, len(steps))
        omega = state.gait.omega
        shares = np.zeros(PREVIEW_STEPS)
        for i, (start, transfer) in enumerate(zip(starts, transfers, strict=True)):
            last = 0.5 if i == len(steps) - 1 else 1.0
            shares[i] = (
                last
                * (math.exp(-omega * start) - math.exp(-omega * (start + transfer)))
                / (omega * transfer)
            )
        feet = [stance, *(step.placement for step in steps)]
        yaws = [wrap_angle(foot.yaw - stance.yaw) for foot in feet]
        arrivals = [start + 0.5 * t for start, t in zip(starts, transfers, strict=True)]
        times = self._program.interval(omega) * np.arange(NODES)
        on_foot = np.searchsorted(arrivals, times)
        step_axes = np.ones(PREVIEW_STEPS, dtype=complex)
        step_axes[: len(steps)] = np.exp(1j * np.array(yaws[:-1]))
        self._solution = solution = self._program.solve(
            error,
            self._zmp,
            np.exp(1j * np.array(yaws))[on_foot],
            self._zmp_bounds(state, times),
            step_axes,
            shares,
            self._step_bounds(state, feet),
        )
        self._age = 0.0
        self._solved_for = (state.phase, state.steps, state.gait, state.duration)
        if solution is None:
            self._dcm = self._zmp = self._displacement = 0j
            self.failures += 1
            if self.failures == 1:
                warnings.warn(
                    "the model-predictive planner found no solution: the analytic DCM plan takes "
                    "its place until it finds one (MpcPlanner.failures counts how often)",
                    PlanFailed,
                    stacklevel=2,
                )
            return
        self._zmp = complex(solution.zmp[0])
        self._dcm = error - solution.missed
        if state.phase is SWING:
            # The analytic plan for the displaced landing place differs by this already.
            self._displacement = complex(solution.footsteps[0])
            self._dcm -= float(shares[0]) * self._displacement

    def _transfers(self, state: GaitState, steps: int) -> tuple[list[float], list[float]]:
        """When the weight begins to move on to each footstep from now on, and how long it does."""
        gait = state.gait
        durations = [gait.double_support] * (steps - 1) + [gait.first_transfer]
        starts = [state.remaining]
        if state.phase is TRANSFER:
            starts[0] += gait.single_support
        for duration in durations[:-1]:
            starts.append(starts[-1] + duration + gait.single_support)
        return starts, durations

    def _zmp_bounds(self, state: GaitState, times: np.ndarray) -> np.ndarray:
        """Return how far the ZMP may be off its path at each node, in the axes of the soles, m.

        On the sole in a swing. While the weight is still to move in the present transfer, half of
        the way to either foot across the soles as well: a box within both feet's polygon.
        """
        half = self._half_size
        bounds = np.empty((2, NODES, 2))
        bounds[1] = half.real, half.imag
        bounds[0] = -bounds[1]
        if state.phase is TRANSFER:
            stance = state.stance
            zmp, other = self._present_zmp(state)[0].start, state.other_foot.point
            to_come = np.clip(1.0 - times / max(state.remaining, 1e-3), 0.0, 1.0)
            planned = to_come * stance.to_local(zmp).imag
            # Within reach until the other foot has left the ground.
            feet = np.stack((-planned, stance.to_local(other).imag - planned)) * (to_come > 0.0)
            bounds[0, :, 1] += 0.5 * np.minimum(feet.min(axis=0), 0.0)
            bounds[1, :, 1] += 0.5 * np.maximum(feet.max(axis=0), 0.0)
        return bounds.reshape(2, -1)

    def _step_bounds(self, state: GaitState, feet: list[Placement]) -> np.ndarray:
        """Return how far each footstep may be displaced from the one before it, m."""
        if self._preview.given or self._follows_given:
            return _FIXED
        bounds, limits, side = _FIXED.copy(), state.limits, state.swing_side
        widest = limits.greatest_width
        for i, (foot, step) in enumerate(pairwise(feet)):
            at, sign = foot.to_local(step.point), lateral_sign(side)
            apart = sorted((sign * limits.least_width, sign * widest))
            bounds[0, 2 * i : 2 * i + 2] = -limits.max_step - at.real, apart[0] - at.imag
            bounds[1, 2 * i : 2 * i + 2] = limits.max_step - at.real, apart[1] - at.imag
            side = other_side(side)
        np.minimum(bounds[0], 0.0, out=bounds[0])
        np.maximum(bounds[1], 0.0, out=bounds[1])
        swing = state.swing
        if isinstance(swing, SwingFoot) and swing.target_frozen:
            bounds[:, :2] = self._displacement.real, self._displacement.imag
        return bounds
