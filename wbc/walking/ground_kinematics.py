"""Soles and centre of mass over the ground, read from the kinematics by one call per tick."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from wbc.gait import Feet, Placement
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.walking.kernels.ground import BODY, read_ground


class CentroidalMotion(NamedTuple):
    """Motion of the centre of mass over the ground, and the momentum that it has there.

    Attributes:
        point: ground point below the centre of mass, m.
        velocity: its velocity, m/s.
        vertical_velocity: of the centre of mass, m/s.
        momentum: angular momentum k about `point` over the weight, `(k_y − i k_x) / (m g)`, m·s:
            that of a linear inverted pendulum of height z is `z ċ / g`.
    """

    point: complex
    velocity: complex
    vertical_velocity: float
    momentum: complex


class GroundKinematics:
    """Reads from kinematics what gait and stabilizer need.

    Args:
        robot: the robot.
        kin: kinematics of the robot; whoever owns it updates it.

    Attributes:
        slopes: slopes of the left and of the right sole: rise per metre along world x, and along y
            as the imaginary part.
    """

    def __init__(self, robot: Robot, kin: Kinematics) -> None:
        self._kin = kin
        self._body = np.zeros(1, BODY)
        body = self._body[0]
        body["mass"] = kin.mass
        for k, sole in enumerate(robot.soles):
            body["joint"][k] = sole.joint_id
            body["axis"][k] = sole.placement.rotation[:, 0]
            body["normal"][k] = sole.placement.rotation[:, 2]
            body["position"][k] = sole.placement.translation
        self._weight = robot.weight
        self._gravity = robot.gravity
        self._out = np.zeros(27)
        self.slopes = (0j, 0j)

    def read(self) -> tuple[Feet, CentroidalMotion]:
        """Return both soles and the motion of the centre of mass, world axes."""
        kin, out = self._kin, self._out
        read_ground(kin.joint_placements, kin.mass_matrix, kin.state.v, self._body, out)
        x, y, z, yaw, right_x, right_y, right_z, right_yaw, *motion = out.tolist()
        left = Placement(complex(x, y), yaw, z)
        right = Placement(complex(right_x, right_y), right_yaw, right_z)
        c_x, c_y, c_z, v_x, v_y, v_z, l_x, l_y, *rest = motion
        left_x, left_y, other_x, other_y = rest[7:]
        self.slopes = (complex(left_x, left_y), complex(other_x, other_y))
        velocity, height = complex(v_x, v_y), c_z - 0.5 * (z + right_z)
        momentum = velocity * (height / self._gravity) + complex(l_y, -l_x) / self._weight
        return Feet(left, right), CentroidalMotion(complex(c_x, c_y), velocity, v_z, momentum)
