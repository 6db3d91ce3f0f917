"""Soles and centre of mass on the ground, read from the kinematics by one call per tick."""

from __future__ import annotations

import numpy as np

from wbc.gait import Feet, Placement
from wbc.kinematics import Kinematics
from wbc.walking.kernels.ground import SOLE, read_ground


class GroundKinematics:
    """Reads from kinematics what gait and stabilizer need.

    Args:
        kin: kinematics of the robot; whoever owns it updates it.
    """

    def __init__(self, kin: Kinematics) -> None:
        self._kin = kin
        self._soles = np.zeros(2, SOLE)
        for row, sole in zip(self._soles, kin.robot.soles, strict=True):
            row["joint"] = sole.joint_id
            row["axis"] = sole.placement.rotation[:, 0]
            row["position"] = sole.placement.translation
        self._out = np.zeros(13)

    def read(self) -> tuple[Feet, complex, complex]:
        """Return both soles, the point below the CoM (m) and its velocity (m/s), world axes."""
        kin, out = self._kin, self._out
        read_ground(kin.joint_placements, kin.mass_matrix, kin.state.v, self._soles, kin.mass, out)
        x, y, z, yaw, right_x, right_y, right_z, right_yaw, v_x, v_y, *_ = out.tolist()
        left = Placement(complex(x, y), yaw, z)
        right = Placement(complex(right_x, right_y), right_yaw, right_z)
        com_x, com_y, _ = kin.p_com.tolist()
        return Feet(left, right), complex(com_x, com_y), complex(v_x, v_y)
