"""The motors of a Unitree G1 with 29 joints."""

from __future__ import annotations

import numpy as np

from wbc.hardware.errors import HardwareError
from wbc.robot import Robot

_LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
_ARM = (
    "shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch",
    "wrist_yaw",
)  # fmt: skip
#: Joints in the order of the motors in a message.
G1_JOINTS = (
    *(f"{side}_{joint}_joint" for side in ("left", "right") for joint in _LEG),
    *(f"waist_{axis}_joint" for axis in ("yaw", "roll", "pitch")),
    *(f"{side}_{joint}_joint" for side in ("left", "right") for joint in _ARM),
)
#: `mode_machine` of G1s with 29 joints: revision 1.0, and those before it.
G1_MACHINES = (5, 2)
#: `mode_machine` that stands for a simulation, by the maker's convention; it may state neither
#: a checksum nor a time.
SIMULATOR_MACHINE = 0
SERIES_MODE = 0  #: `mode_pr`: ankles are commanded in pitch and roll, not by their two motors


def motor_of_joint(robot: Robot) -> np.ndarray:
    """Return the index of the motor of each joint of a G1's model, (29,).

    Raises:
        HardwareError: the robot has other joints than a G1 with 29.
    """
    if sorted(robot.joint_names) != sorted(G1_JOINTS):
        missing = sorted(set(G1_JOINTS) ^ set(robot.joint_names))
        raise HardwareError(
            f"the model '{robot.name}' has not the joints of a G1 with 29 joints: '{missing[0]}' "
            "and others differ; load the robot 'g1'"
        )
    return np.array([G1_JOINTS.index(name) for name in robot.joint_names])
