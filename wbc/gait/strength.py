"""Whether the legs are strong enough to walk: the torques of the leg that carries the robot."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin

from wbc.errors import GaitError
from wbc.gait.footsteps import SIDES
from wbc.gait.leg_workspace import LegWorkspace
from wbc.gait.step_motion import StepMotion
from wbc.robot import Robot
from wbc.robot.statics import holding_torques

if TYPE_CHECKING:  # which refuses what is too weak
    from wbc.gait.parameters import GaitParameters

# Share of a joint's limit that a posture may take: leaning the trunk saves a tenth.
_BEARABLE = 1.1
_CURE = "correct the effort limit or the masses, or state a posture with straighter knees"


class SupportEffort(NamedTuple):
    """The joint that needs the largest share of its torque to carry the robot on one leg.

    Attributes:
        joint: its name.
        torque: what it needs, N·m.
        share: the same as a share of its limit.
    """

    joint: str
    torque: float
    share: float


def support_effort(robot: Robot, motion: StepMotion, gait: GaitParameters) -> SupportEffort:
    """Return the effort of stepping on the spot; see `StepMotion.support_torques`.

    Raises:
        GaitError: a leg does not reach where it stands and steps then.
    """
    worst = SupportEffort("", 0.0, 0.0)
    for side, leg in zip(SIDES, robot.legs, strict=True):
        torques = np.abs(motion.support_torques(gait, side))
        if np.isnan(torques).any():
            raise GaitError(
                f"'{robot.name}' cannot walk: with the centre of mass {gait.com_height:.3g} m "
                f"above its {side} sole and the other foot lifted by {gait.swing_height:.3g} m, "
                "its legs cannot hold both soles level; state a posture with more bent knees, or "
                "fix no joints of the legs"
            )
        for torque, index in zip(torques.tolist(), leg, strict=True):
            share = torque / float(robot.tau_max[index - 6])
            if share > worst.share:
                worst = SupportEffort(robot.joint_names[index - 6], torque, share)
    return worst


def foot_acceleration(robot: Robot) -> float:
    """Return how fast the legs' torques accelerate a foot that is in the air, horizontally, m/s².

    In the nominal posture, with the body at rest: the torques `M J⁺ a` are at their limit. The
    smallest of both feet, forward and to the side.

    Args:
        robot: the robot.
    """
    model, q = robot.model, robot.q_nominal
    data = model.createData()
    pin.computeJointJacobians(model, data, q)
    mass_matrix = pin.crba(model, data, q)
    least = math.inf
    for sole, leg in zip(robot.soles, robot.legs, strict=True):
        joints = np.array(leg)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        jacobian = pin.getFrameJacobian(model, data, sole.frame_id, axes)[:, joints]
        motion = np.linalg.pinv(jacobian)[:, :2]
        torques = np.abs(mass_matrix[np.ix_(joints, joints)] @ motion)
        least = min(least, 1.0 / float((torques / robot.tau_max[joints - 6, None]).max()))
    return least


def check_knees(robot: Robot, workspace: LegWorkspace) -> None:
    """Check that the knees bear the weight while they bend as far as the shortest steps do.

    Raises:
        GaitError: they do not; the text names the knee, its torque and the bound.
    """
    if workspace.max_step > 0.0:
        return
    knee = min(workspace.knees, key=lambda index: float(robot.tau_max[index]))
    raise GaitError(
        f"'{robot.name}' cannot walk: its knee '{robot.joint_names[knee]}' has "
        f"{robot.tau_max[knee]:.3g} N·m, and to carry {robot.mass:.3g} kg over even the shortest "
        f"step takes {workspace.min_knee_torque:.3g} N·m; {_CURE}"
    )


def check_support(robot: Robot, motion: StepMotion, gait: GaitParameters) -> None:
    """Check that the legs can hold the nominal posture, and each leg the robot alone.

    Raises:
        GaitError: it cannot; the text names the joint, its torque and the bound.
    """
    torques = np.abs(
        holding_torques(robot.model, robot.q_nominal, [s.frame_id for s in robot.soles])
    )
    legs = [int(index) - 6 for leg in robot.legs for index in leg]
    worst = max(legs, key=lambda joint: float(torques[joint] / robot.tau_max[joint]))
    if torques[worst] > _BEARABLE * robot.tau_max[worst]:
        raise GaitError(
            f"'{robot.name}' cannot stand: its joint '{robot.joint_names[worst]}' has "
            f"{robot.tau_max[worst]:.3g} N·m, and to hold the nominal posture takes "
            f"{torques[worst]:.3g} N·m; {_CURE}"
        )
    effort = support_effort(robot, motion, gait)
    if effort.share > _BEARABLE:
        raise GaitError(
            f"'{robot.name}' cannot walk: its joint '{effort.joint}' has "
            f"{effort.torque / effort.share:.3g} N·m, and to carry {robot.mass:.3g} kg on one leg "
            f"takes {effort.torque:.3g} N·m; {_CURE}"
        )
