"""Kinematics of the chains between IMU, base and soles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from wbc.estimation.kernels.legs import LINK, poses_type
from wbc.robot import Robot
from wbc.robot.joint_axes import joint_axes


class LegKinematics:
    """Poses of base and soles as seen from the IMU, and its motion relative to the base.

    The kernel `wbc.estimation.kernels.prediction.predict` computes them.

    Args:
        robot: its model.

    Attributes:
        links: records of the type `LINK`: the chain of the IMU, then those of the soles.
        ends: (1 + feet,) index after the last link of each chain.
        poses: (1,) record of the type `poses_type`.
    """

    def __init__(self, robot: Robot) -> None:
        model = robot.model
        imu = model.frames[robot.frame_id(robot.imu)]
        axes = joint_axes(model)
        chains = [_links(model, axes, imu.parentJoint, imu.placement)]
        chains += [_links(model, axes, s.joint_id, s.placement) for s in robot.soles]
        links = [list(chain) for chain in chains]
        self.links = np.concatenate([link for chain in links for link in chain])
        self.ends = np.cumsum([len(chain) for chain in links])
        self.poses = np.zeros(1, poses_type(len(robot.soles)))

    @property
    def sole_positions(self) -> np.ndarray:
        """Sole centres in IMU axes, (feet, 3), m; a view."""
        positions: np.ndarray = self.poses["sole_position"][0]
        return positions

    @property
    def sole_rotations(self) -> np.ndarray:
        """Sole axes to IMU axes, (feet, 3, 3); a view."""
        rotations: np.ndarray = self.poses["sole_rotation"][0]
        return rotations


def _links(
    model: pin.Model, axes: list[np.ndarray], joint: int, end: pin.SE3
) -> Iterator[np.ndarray]:
    """Yield the links from the base to a frame, each a (1,) record of the type `LINK`.

    Args:
        model: the robot's.
        axes: motion subspace of each joint, (6,).
        joint: joint that carries the frame.
        end: placement of the frame on it.
    """
    for i in list(model.supports[joint])[2:]:  # behind the universe and the base
        yield _link(model.jointPlacements[i], axes[i], model.joints[i].idx_v - 6)
    yield _link(end, np.zeros(6), -1)


def _link(placement: pin.SE3, axis: np.ndarray, joint: int) -> np.ndarray:
    link = np.zeros(1, LINK)
    K = pin.skew(axis[3:])
    link["rotation"], link["position"] = placement.rotation, placement.translation
    link["sine"], link["versine"] = placement.rotation @ K, placement.rotation @ K @ K
    link["slide"], link["axis"], link["joint"] = axis[:3], axis[3:], joint
    return link


def leg_covariance(robot: Robot, index: int, encoder: float) -> np.ndarray:
    """Return the covariance of a sole's pose as the encoders see it, at the nominal posture.

    `C = σ² J Jᵀ` with the Jacobian of the sole relative to the IMU; position, then
    rotation vector, IMU axes; m, rad; (6, 6).

    Args:
        robot: the robot.
        index: index of the sole.
        encoder: σ, rad.
    """
    model, sole = robot.model, robot.soles[index]
    data = model.createData()
    q = np.array(robot.q_nominal)
    q[:7] = pin.neutral(model)[:7]
    pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    imu = robot.frame_id(robot.imu)
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    J = pin.getFrameJacobian(model, data, sole.frame_id, axes)[:, 6:]
    J_imu = pin.getFrameJacobian(model, data, imu, axes)[:, 6:]
    lever = data.oMf[sole.frame_id].translation - data.oMf[imu].translation
    J = J - J_imu
    J[:3] += pin.skew(lever) @ J_imu[3:]
    R = data.oMf[imu].rotation.T
    J = np.vstack([R @ J[:3], R @ J[3:]])
    # A leg of fewer than six joints alone would make the filter singular.
    C: np.ndarray = encoder**2 * (J @ J.T) + 1e-8 * np.eye(6)
    return C
