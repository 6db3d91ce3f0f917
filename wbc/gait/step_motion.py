"""Joint angles and speeds of the legs in steady walking, from inverse kinematics."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from wbc.gait.footsteps import SIDES, Velocity, next_footstep, other_side
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.swing_foot import SwingFoot
from wbc.gait.yaw_moment import YawMoment
from wbc.geometry.planar import Placement, planar_rotation, rotation_about_z
from wbc.robot import Robot
from wbc.robot.statics import smallest_wrenches
from wbc.robot.topology import reduced_model

if TYPE_CHECKING:  # which has the limits that are found here
    from wbc.gait.parameters import GaitParameters

_SAMPLES = 8  # of a swing
_ITERATIONS = 8
_CONVERGED = 1e-4  # m, rad
_REACHED = 5e-3  # m, rad: farther off, a leg does not reach its foot
_DAMPING = 1e-6  # of Newton's method
_LARGEST_STEP = 0.5  # rad
_FREE_ROTATION = 1e-3  # weight of the orientation of a foot whose leg has too few joints for it
_MARGIN = 0.03  # rad that hips and knees keep from their limits; balance takes the rest
_TILT = 0.15  # rad by which an ankle may be beyond them: a foot that leaves the ground may tilt
_SPEED = 1.4  # share of a joint's speed limit: at the peak the foot may lag behind
_CENTRING = 3  # times that the base moves until the CoM is where it should be


class StepMotion:
    """What steady walking at a velocity asks of the leg joints.

    During a swing the centre of mass moves as the linear inverted pendulum on the support foot,
    between the places where it is at lift-off and at touchdown; the trunk is upright and has the
    mean heading of the feet. Leg angles follow by inverse kinematics.

    Args:
        robot: the robot.
        workspace: workspace of its legs.
    """

    def __init__(self, robot: Robot, workspace: LegWorkspace) -> None:
        self._workspace = workspace
        model, q = robot.model, robot.standing().q
        moving = [int(i) for leg in robot.legs for i in leg]
        locked = [j for j in range(2, model.njoints) if model.idx_vs[j] not in moving]
        self._model = reduced_model(model, locked, q)
        self._data = self._model.createData()
        joints = {model.idx_vs[j]: model.names[j] for j in range(2, model.njoints)}
        # Of each leg, the columns of its joints in the reduced model.
        self._legs = [
            [self._model.idx_vs[self._model.getJointId(joints[int(i)])] for i in leg]
            for leg in robot.legs
        ]
        # A leg of fewer than six joints places its foot, and turns it as far as it can.
        self._weights = [
            np.array([1.0] * 3 + [1.0 if len(leg) >= 6 else _FREE_ROTATION] * 3)
            for leg in robot.legs
        ]
        self._exact = [weight == 1.0 for weight in self._weights]
        self._frames = [self._model.getFrameId(sole.name) for sole in robot.soles]
        self._start = pin.neutral(self._model)
        self._start[:7] = q[:7]
        for i in moving:
            joint = self._model.getJointId(joints[i])
            self._start[self._model.idx_qs[joint]] = q[i + 1]
        # A knee stays on its side of being straight, where the other solution begins.
        self._range = {c: (-math.inf, math.inf) for columns in self._legs for c in columns}
        for i in workspace.knees:
            column = self._model.idx_vs[self._model.getJointId(joints[i + 6])]
            self._range[column] = (float(robot.q_min[i]), float(robot.q_max[i]))
        indices = np.array(moving) - 6
        self._ankles = np.concatenate([np.arange(len(leg)) >= len(leg) - 2 for leg in robot.legs])
        self._q_min, self._q_max = robot.q_min[indices], robot.q_max[indices]
        self._v_max = robot.v_max[indices]
        data = model.createData()
        com = pin.centerOfMass(model, data, q)
        ground = float(com[2]) - robot.com_height
        self._base = q[:3] - np.array([com[0], com[1], ground])
        self._base_rotation = pin.Quaternion(q[3:7]).matrix()
        self._com_height = robot.com_height
        self._yaw_moment = YawMoment(robot)

    def excess(
        self, gait: GaitParameters, velocity: Velocity, *, swings_arms: bool = False
    ) -> np.ndarray:
        """By how much each joint is beyond its range (rad) or its speed (share); ≤ 0: within.

        Args:
            gait: its timing, width and height.
            velocity: of the walk.
            swings_arms: whether the arms swing against the legs, as in fast walking.

        Returns:
            (2 joints + 1,): positions, speeds, and the moment about the vertical that the swing
            leg needs beyond what arms and support sole have for it, N·m.
        """
        play = np.where(self._ankles, -_TILT, _MARGIN)
        dt = gait.single_support / _SAMPLES
        worst = np.full(2 * play.size, -math.inf)
        for q in self.angles(gait, velocity):
            if not np.isfinite(q).all():
                return np.full(worst.size + 1, math.inf)
            position = np.maximum(self._q_min - q, q - self._q_max).max(axis=0) + play
            speed = (np.abs(np.diff(q, axis=0)) / (dt * self._v_max)).max(axis=0) - _SPEED
            worst = np.maximum(worst, np.concatenate([position, speed]))
        length = velocity.forward * gait.step_duration
        period = gait.step_duration if swings_arms else math.inf
        return np.append(worst, self._yaw_moment.excess(length, gait.single_support, period))

    def angles(self, gait: GaitParameters, velocity: Velocity) -> Iterator[np.ndarray]:
        """Return the (samples, joints) angles of both legs in each swing of a cycle, rad.

        A row is infinite where a leg does not reach its foot.
        """
        step = velocity.speed * gait.step_duration
        height = min(gait.com_height, self._workspace.com_height(step, gait.trail))
        feet = {
            "left": Placement(0j, 0.0),
            "right": Placement(complex(0.0, -gait.step_width), 0.0),
        }
        for k in range(4):
            side = SIDES[k % 2]
            stance, start = feet[other_side(side)], feet[side]
            landing = next_footstep(stance, side, velocity, gait)
            if k >= 2:
                yield self._swing(gait, side, stance, start, landing, height)
            feet[side] = landing

    def support_torques(self, gait: GaitParameters, support: str) -> np.ndarray:
        """Return the torques of the leg that carries the robot alone, in the middle of a swing.

        The robot steps on the spot. The ground's force acts at the centre of the sole and points
        to the centre of mass, which therefore accelerates as the linear inverted pendulum does:
        every body has the weight `m (g − c̈)`, `c̈ = g (c − p) / h`.

        Args:
            gait: timing, width and height of the steps.
            support: side of the supporting foot.

        Returns:
            (n,) torques of the leg's joints, from the hip down, N·m; NaN if it does not reach.
        """
        model, data, side = self._model, self._data, SIDES.index(support)
        ground = Placement(0j, 0.0)
        lifted = next_footstep(ground, other_side(support), Velocity(), gait).point
        beside = _beside(gait) / math.cosh(0.5 * gait.omega * gait.single_support)
        foot = pin.SE3(np.eye(3), np.array([lifted.real, lifted.imag, gait.swing_height]))
        targets = (pin.SE3.Identity(), foot) if side == 0 else (foot, pin.SE3.Identity())
        q = self._start.copy()
        self._place_base(q, 1j * beside * lifted.imag, 0.0, gait.com_height)
        for _ in range(_CENTRING):
            legs = self._solve(q, targets)
            if not np.isfinite(legs).all():
                return np.full(len(self._legs[side]), math.nan)
            com = pin.centerOfMass(model, data, q)
            q[0] -= com[0]
            q[1] += beside * lifted.imag - com[1]
        self._solve(q, targets)
        com = pin.centerOfMass(model, data, q)
        upright = model.gravity.linear.copy()
        model.gravity.linear = -gait.gravity / com[2] * com
        weight = pin.computeGeneralizedGravity(model, data, q)
        model.gravity.linear = upright
        pin.computeJointJacobians(model, data, q)
        J = pin.computeFrameJacobian(model, data, q, self._frames[side], pin.LOCAL)
        torque = weight - J.T @ smallest_wrenches(J, weight[:6])
        return np.asarray(torque[self._legs[side]])

    def _swing(
        self,
        gait: GaitParameters,
        side: str,
        stance: Placement,
        start: Placement,
        landing: Placement,
        height: float,
    ) -> np.ndarray:
        omega, T = gait.omega, gait.single_support
        a, b = 0.5 * omega * T, 0.5 * omega * gait.double_support
        ahead = 0.5 * math.sinh(a) / (math.sinh(a) + b * math.cosh(a))
        beside = _beside(gait)
        first, last = (stance.to_local(p.point) for p in (start, landing))
        first, last = (complex(ahead * p.real, beside * p.imag) for p in (first, last))
        foot = SwingFoot(start, landing, T, gait.swing_height, gait.touchdown_speed)
        dt = T / _SAMPLES
        rows = []
        q = self._start.copy()
        for k in range(_SAMPLES + 1):
            t = k * dt
            com = (first * math.sinh(omega * (T - t)) + last * math.sinh(omega * t)) / math.sinh(
                omega * T
            )
            yaw = stance.yaw + 0.5 * (foot.yaw - stance.yaw)
            self._place_base(q, stance.to_world(com), yaw, height)
            swing = pin.SE3(rotation_about_z(foot.yaw), np.array(foot.motion.position))
            support = pin.SE3(
                rotation_about_z(stance.yaw), np.array([stance.point.real, stance.point.imag, 0.0])
            )
            targets = (swing, support) if side == "left" else (support, swing)
            rows.append(self._solve(q, targets))
            foot.advance(dt, landing)
        return np.array(rows)

    def _place_base(self, q: np.ndarray, com: complex, yaw: float, height: float) -> None:
        offset = complex(self._base[0], self._base[1]) * planar_rotation(yaw)
        q[0], q[1] = com.real + offset.real, com.imag + offset.imag
        q[2] = self._base[2] - self._com_height + height
        rotation = rotation_about_z(yaw) @ self._base_rotation
        q[3:7] = pin.Quaternion(rotation).coeffs()

    def _solve(self, q: np.ndarray, targets: tuple[pin.SE3, pin.SE3]) -> np.ndarray:
        """Move the legs in q to their feet by Newton's method; return their angles, rad."""
        model, data = self._model, self._data
        for _ in range(_ITERATIONS):
            pin.computeJointJacobians(model, data, q)
            worst = 0.0
            for columns, frame, target, weight, exact in zip(
                self._legs, self._frames, targets, self._weights, self._exact, strict=True
            ):
                placement = pin.updateFramePlacement(model, data, frame)
                error = pin.log6(placement.actInv(target)).vector
                worst = max(worst, float(np.abs(error[exact]).max()))
                J = pin.getFrameJacobian(model, data, frame, pin.LOCAL)[:, columns]
                H = (J.T * weight) @ J
                H.flat[:: len(H) + 1] += _DAMPING
                step = np.linalg.solve(H, J.T @ (weight * error))
                for column, delta in zip(columns, step.tolist(), strict=True):
                    angle = float(q[column + 1])
                    lower, upper = (0.5 * (angle + limit) for limit in self._range[column])
                    delta = max(-_LARGEST_STEP, min(_LARGEST_STEP, delta))
                    q[column + 1] = max(lower, min(upper, angle + delta))
            if worst < _CONVERGED:
                break
        if worst > _REACHED:
            return np.full(sum(map(len, self._legs)), math.inf)
        return np.array([q[c + 1] for columns in self._legs for c in columns])


def _beside(gait: GaitParameters) -> float:
    """Return the CoM's lateral distance from the support foot at lift-off, share of the width."""
    a, b = 0.5 * gait.omega * gait.single_support, 0.5 * gait.omega * gait.double_support
    return 0.5 * math.cosh(a) / (math.cosh(a) + b * math.sinh(a))
