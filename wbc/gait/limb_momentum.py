"""Angular momentum of limbs that swing."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody


def swing_momentum(robot: Robot) -> np.ndarray:
    """Angular momentum about the centre of mass per velocity of the left foot, (3, 2) kg·m.

    Its columns belong to velocities forward and to the left. In the nominal posture: the foot moves
    without turning, the support foot and the centre of mass rest, and the trunk keeps its attitude.
    The same matrix leads from the acceleration of a foot that starts from rest to the rate of the
    angular momentum.

    Args:
        robot: the robot.
    """
    model, q = robot.model, robot.standing().q
    data = model.createData()
    pin.ccrba(model, data, q, np.zeros(model.nv))
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    axes = pin.LOCAL_WORLD_ALIGNED
    feet = [pin.getFrameJacobian(model, data, sole.frame_id, axes) for sole in robot.soles]
    com = pin.jacobianCenterOfMass(model, data, q)
    moving = [0, 1, 2, *(int(index) for leg in robot.legs for index in leg)]
    constraints = np.vstack([*feet, com])[:, moving]
    wanted = np.eye(15)[:, :2]
    # Legs of fewer than six degrees of freedom leave rows that depend on each other.
    motion = np.linalg.lstsq(constraints, wanted, rcond=1e-6)[0]
    return np.asarray(data.Ag[3:, moving] @ motion)


def arm_yaw_momentum(robot: Robot) -> float:
    """Angular momentum about the vertical per velocity of the arms' joints, kg·m²/s per rad/s.

    In the nominal posture, with both arms swinging against each other, each joint at the same
    speed: `Σ |A_zj|` with the centroidal momentum matrix A (Orin, Goswami and Lee, Centroidal
    dynamics of a humanoid robot, Autonomous Robots 2013). 0 without arms.

    Args:
        robot: the robot.
    """
    model, q = robot.model, robot.standing().q
    data = model.createData()
    pin.ccrba(model, data, q, np.zeros(model.nv))
    joints = [6 + index for arm in UpperBody.of(robot).arms for index in arm.joints]
    return float(np.abs(data.Ag[5, joints]).sum())
