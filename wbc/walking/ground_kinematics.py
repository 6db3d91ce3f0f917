"""Soles and centre of mass on the ground, read from the kinematics by one call per tick."""

from __future__ import annotations

import numpy as np

from wbc.gait import Feet, Placement
from wbc.kinematics import Kinematics
from wbc.walking.kernels.ground import BODY, read_ground


class GroundKinematics:
    """Reads from kinematics what gait and stabilizer need.

    Args:
        kin: kinematics of the robot; whoever owns it updates it.

    Attributes:
        slopes: slopes of the left and of the right sole: rise per metre along world x, and along y
            as the imaginary part.
    """

    def __init__(self, kin: Kinematics) -> None:
        self._kin = kin
        self._body = np.zeros(1, BODY)
        body = self._body[0]
        body["mass"] = kin.mass
        for k, sole in enumerate(kin.robot.soles):
            body["joint"][k] = sole.joint_id
            body["axis"][k] = sole.placement.rotation[:, 0]
            body["normal"][k] = sole.placement.rotation[:, 2]
            body["position"][k] = sole.placement.translation
        self._out = np.zeros(19)
        self.slopes = (0j, 0j)

    def read(self) -> tuple[Feet, complex, complex]:
        """Return both soles, the point below the CoM (m) and its velocity (m/s), world axes."""
        kin, out = self._kin, self._out
        read_ground(kin.joint_placements, kin.mass_matrix, kin.state.v, self._body, out)
        x, y, z, yaw, right_x, right_y, right_z, right_yaw, c_x, c_y, v_x, v_y, *rest = out.tolist()
        left_x, left_y, other_x, other_y = rest[3:]
        self.slopes = (complex(left_x, left_y), complex(other_x, other_y))
        left = Placement(complex(x, y), yaw, z)
        right = Placement(complex(right_x, right_y), right_yaw, right_z)
        return Feet(left, right), complex(c_x, c_y), complex(v_x, v_y)
