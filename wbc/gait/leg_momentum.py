"""Angular momentum of a leg that swings."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from wbc.robot import Robot


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
    motion = np.linalg.lstsq(constraints, wanted, rcond=None)[0]
    return np.asarray(data.Ag[3:, moving] @ motion)
