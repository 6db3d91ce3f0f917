"""Checks of a keyframe plan against the robot's limits, before it starts."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.ik.posture_checks import holding_effort, pelvis_violation, support_half_size
from wbc.motions.keyframing.keyframe import KeyframeError
from wbc.motions.keyframing.plan import KeyframePlan, KeyframePlanner

_STEP = 0.01  # s
_EVERY = 10  # steps between two checks of the torques
_MAX_TORQUE_SHARE = 0.95  # of any torque limit
_SUPPORT = 0.8  # share of the soles over which the ZMP may move


def check_limits(planner: KeyframePlanner, plan: KeyframePlan) -> None:
    """Check positions and velocities of all joints, torques, pelvis and ZMP over the motion.

    Torques are those of the motion on a fixed base, and for the legs those at rest. The ZMP is
    that of the linear inverted pendulum, `p = c − c̈ / ω²`.

    Raises:
        KeyframeError: with line and column of the value that causes it.
    """
    robot = planner.robot
    half = support_half_size(robot)
    _check_keyed(planner)
    for k in range(int(plan.duration / _STEP) + 1):
        time = k * _STEP
        q, v, a = plan.posture.derivatives(time)
        over = np.maximum(q - robot.q_max, robot.q_min - q)
        _refuse(planner, time, over > 1e-6, q, robot.q_min, robot.q_max, "position")
        _refuse(planner, time, np.abs(v) > robot.v_max, v, -robot.v_max, robot.v_max, "velocity")
        if k % _EVERY == 0:
            _check_torques(planner, time, q, v, a)
            _check_pelvis(planner, time, q)
        _check_zmp(planner, plan, time, half)


def _check_keyed(planner: KeyframePlanner) -> None:
    """Check the positions as they are written, before those in between."""
    robot = planner.robot
    for frame in planner.frames:
        for name, value in frame.joints.items():
            joint, q = robot.joint_index(name), robot.q_nominal[7:].copy()
            q[joint] = value.number
            bad = np.zeros(robot.na, dtype=bool)
            bad[joint] = not robot.q_min[joint] <= value.number <= robot.q_max[joint]
            _refuse(planner, frame.time.number, bad, q, robot.q_min, robot.q_max, "position")


def _check_pelvis(planner: KeyframePlanner, time: float, posture: np.ndarray) -> None:
    violation = pelvis_violation(planner.robot, planner.place_on_soles(posture))
    if violation:
        where = planner.value_at(0, time).where
        raise KeyframeError(planner.source, where, f"at {time:.2f} s {violation}")


def _refuse(
    planner: KeyframePlanner,
    time: float,
    bad: np.ndarray,
    value: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    what: str,
) -> None:
    if not bad.any():
        return
    joint = int(np.flatnonzero(bad)[0])
    unit = {"position": "rad", "velocity": "rad/s", "torque": "N·m"}[what]
    raise KeyframeError(
        planner.source,
        planner.value_at(joint, time).where,
        f"{what} of '{planner.robot.joint_names[joint]}' at {time:.2f} s would be "
        f"{value[joint]:.3f} {unit}, beyond [{low[joint]:.2f}, {high[joint]:.2f}]",
    )


def _check_torques(
    planner: KeyframePlanner, time: float, q: np.ndarray, v: np.ndarray, a: np.ndarray
) -> None:
    robot = planner.robot
    whole = robot.q_nominal.copy()
    whole[7:] = q
    zero = np.zeros(6)
    model, data = robot.model, robot.model.createData()
    torque = pin.rnea(model, data, whole, np.concatenate((zero, v)), np.concatenate((zero, a)))[6:]
    legs = [j - 6 for leg in robot.legs for j in leg]
    torque[legs] = holding_effort(robot, whole).torque[legs]
    limit = _MAX_TORQUE_SHARE * robot.tau_max
    _refuse(planner, time, np.abs(torque) > limit, torque, -limit, limit, "torque")


def _check_zmp(planner: KeyframePlanner, plan: KeyframePlan, time: float, half: np.ndarray) -> None:
    robot = planner.robot
    c, _, a = plan.com.derivatives(time)
    zmp = (c - a * robot.com_height / robot.gravity)[:2]
    if (np.abs(zmp) > _SUPPORT * half).any():
        raise KeyframeError(
            planner.source,
            planner.value_at(0, time).where,
            f"at {time:.2f} s the CoM would be too far out or too fast to balance: its ZMP "
            f"({zmp[0]:.3f}, {zmp[1]:.3f}) m lies beyond ±({_SUPPORT * half[0]:.3f}, "
            f"{_SUPPORT * half[1]:.3f}) m",
        )
