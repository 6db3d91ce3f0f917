"""Helpers for the tests of the plant and of the estimator."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.measurement import Measurement
from wbc.robot import Robot, load
from wbc.sim import Mujoco
from wbc.state import State


@cache
def robot(name: str = "talos") -> Robot:
    return load(name)


def command(tau: np.ndarray) -> Command:
    return Command(tau, np.empty(0), {}, np.empty(0), np.empty(0))


def moved(state: State, shift: tuple[float, float, float], yaw: float) -> State:
    """Return the same posture with a shifted base, m, rotated about the vertical by `yaw`, rad."""
    q = state.q.copy()
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(0.0, 0.0, yaw))
    q[:3] = turn.toRotationMatrix() @ q[:3] + np.array(shift)
    q[3:7] = (turn * pin.Quaternion(q[3:7])).coeffs()
    return State(q, state.v.copy())


def random_state(robot: Robot, random: np.random.Generator) -> State:
    q = robot.standing().q.copy()
    q[:3] = random.uniform(-1.0, 1.0, 3) + np.array([0.0, 0.0, 5.0])
    quaternion = random.standard_normal(4)
    q[3:7] = quaternion / np.linalg.norm(quaternion)
    low, high = np.maximum(robot.q_min, -2.0), np.minimum(robot.q_max, 2.0)
    q[7:] = low + (0.1 + 0.8 * random.uniform(size=robot.na)) * (high - low)
    return State(q, random.standard_normal(robot.nv))


def roll_pitch_yaw(state: State) -> np.ndarray:
    """Return roll, pitch and yaw, rad."""
    return pin.rpy.matrixToRpy(pin.Quaternion(state.q[3:7]).toRotationMatrix())


class JointPDController:
    """Joint PD about the standing posture, with the torques of standing still."""

    def __init__(self, robot: Robot) -> None:
        q = robot.standing().q
        model, data = robot.model, robot.model.createData()
        gravity = pin.computeGeneralizedGravity(model, data, q)
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        J = np.vstack(
            [
                pin.getFrameJacobian(model, data, s.frame_id, pin.ReferenceFrame.LOCAL)
                for s in robot.soles
            ]
        )
        wrenches = np.linalg.lstsq(J[:, :6].T, gravity[:6], rcond=None)[0]
        self.tau = (gravity - J.T @ wrenches)[6:]
        self.q = q[7:].copy()
        self.kp = np.minimum(20.0 * robot.tau_max, 4000.0)
        self.kd = 0.01 * self.kp

    def __call__(self, measurement: Measurement, offset: np.ndarray | float = 0.0) -> Command:
        error = self.q + offset - measurement.joint_position
        return command(self.tau + self.kp * error - self.kd * measurement.joint_velocity)


class SwayOffsets:
    """Joint offsets that move the base about on standing feet: down and up, left and right."""

    def __init__(self, robot: Robot, size: float = 0.02) -> None:
        model, data, q = robot.model, robot.model.createData(), robot.standing().q
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        self._per_metre = np.zeros((robot.na, 3))
        for sole, leg in zip(robot.soles, robot.legs, strict=True):
            J = pin.getFrameJacobian(model, data, sole.frame_id, axes)
            columns = np.array(leg)
            self._per_metre[columns - 6] = -np.linalg.pinv(J[:, columns]) @ J[:, :3]
        self._size = size

    def __call__(self, time: float) -> np.ndarray:
        slow, fast = 2.0 * np.pi * 0.4 * time, 2.0 * np.pi * 0.9 * time
        shift = [0.3 * np.sin(fast), np.sin(slow), -0.5 * (1.0 - np.cos(fast))]
        return self._per_metre @ (self._size * np.array(shift))


def run(plant: Mujoco, duration: float, hold: Callable[[Measurement], Command]) -> None:
    for _ in range(round(duration / plant.dt)):
        plant.step(hold(plant.measure()))
