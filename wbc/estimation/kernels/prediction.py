"""What the estimator does in every tick before it corrects: one call for joints, legs and IMU."""

from __future__ import annotations

import math

import numpy as np

from wbc.estimation.kernels.filter_record import FEET, filter_type
from wbc.estimation.kernels.inekf import propagate, propagate_covariance
from wbc.estimation.kernels.joints import update_joints
from wbc.estimation.kernels.legs import LINK, find_poses, find_state, poses_type
from wbc.estimation.kernels.moving_soles import seems_to_move
from wbc.jit.compile import argument_types, kernel, subkernel

#: What `predict` returns.
REFUSED, DONE, CORRECTION_DUE = -1, 0, 1

_VECTOR = np.zeros(1)


@subkernel
def _sum_of_squares(x: np.ndarray) -> float:
    total = 0.0
    for i in range(x.size):
        total += x[i] * x[i]
    return total


@subkernel
def _fits(x: np.ndarray, size: int) -> bool:
    return x.ndim == 1 and x.size == size


@kernel(
    *(
        argument_types(
            np.zeros(1, filter_type(feet)),
            _VECTOR,
            np.zeros((2, 1)),
            np.zeros(1, LINK),
            np.zeros(1, np.int64),
            np.zeros(1, poses_type(feet)),
            np.zeros((2, 5)),
            *(_VECTOR,) * 7,
        )
        for feet in FEET
    )
)
def predict(
    filter_: np.ndarray,
    slip: np.ndarray,
    joints: np.ndarray,
    links: np.ndarray,
    ends: np.ndarray,
    poses: np.ndarray,
    joint_update: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
    acceleration: np.ndarray,
    joint_position: np.ndarray,
    joint_velocity: np.ndarray,
    gyro: np.ndarray,
    accelerometer: np.ndarray,
) -> int:
    """Advance filter and joints by one period, and compute the legs' poses and the robot's state.

    Args:
        filter_: (1,) the invariant filter.
        slip: (feet,) a factor on the drift of each sole; 0 for one in the air.
        joints: (2, na) positions and velocities, rad and rad/s.
        links: see `find_poses`.
        ends: see `find_poses`.
        poses: (1,) result.
        joint_update: (2, 5), see `update_joints`.
        q: (nq,) result, the configuration.
        v: (nv,) result, the generalised velocity.
        acceleration: (na,) foreseen for the joints, rad/s².
        joint_position: (na,) reading, rad.
        joint_velocity: (na,) reading, rad/s.
        gyro: (3,) reading, IMU axes, rad/s.
        accelerometer: (3,) reading, IMU axes, m/s².

    Returns:
        REFUSED when a size is wrong or an entry is not finite, and nothing has changed;
        CORRECTION_DUE when the filter is to be corrected by the legs; else DONE.
    """
    na = joints.shape[1]
    if not (_fits(joint_position, na) and _fits(joint_velocity, na) and _fits(acceleration, na)):
        return REFUSED
    if not (_fits(gyro, 3) and _fits(accelerometer, 3)):
        return REFUSED
    total = _sum_of_squares(joint_position) + _sum_of_squares(joint_velocity)
    total += _sum_of_squares(gyro) + _sum_of_squares(accelerometer) + _sum_of_squares(acceleration)
    # Not `isfinite(total)`, which is `total − total == 0` to the compiler: it may reorder the sums.
    if not total < math.inf:
        return REFUSED
    due = propagate(filter_[0], gyro, accelerometer, slip)
    update_joints(joint_update, joints, acceleration, joint_position, joint_velocity)
    find_poses(links, ends, joints, poses[0])
    find_state(filter_[0], poses[0], joints, q, v)
    if not (due or seems_to_move(filter_[0], poses[0]["sole_position"], slip)):
        return DONE
    propagate_covariance(filter_[0])
    return CORRECTION_DUE
