"""Soles and centre of mass over the ground, read from the kinematics by one call per tick."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from wbc.gait import Feet, Placement
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.walking.kernels.ground import BODY, read_ground

_from_tuple = tuple.__new__


class CentroidalMotion(NamedTuple):
    """Motion of the centre of mass over the ground, and the momentum that it has there.

    Attributes:
        point: ground point below the centre of mass, m.
        velocity: its velocity, m/s.
        height: world height of the centre of mass, m.
        vertical_velocity: of the centre of mass, m/s.
        momentum: angular momentum k about `point` over the weight, `(k_y − i k_x) / (m g)`, m·s:
            that of a linear inverted pendulum of height z is `z ċ / g`.
        centroidal_momentum: the same about the centre of mass itself, `(L_y − i L_x) / (m g)`, m·s;
            zero for the pendulum.
    """

    point: complex
    velocity: complex
    height: float
    vertical_velocity: float
    momentum: complex
    centroidal_momentum: complex


class GroundKinematics:
    """Reads from kinematics what gait and stabilizer need.

    Args:
        robot: the robot.
        kin: kinematics of the robot; whoever owns it updates it.

    Attributes:
        slopes: slopes of the left and of the right sole: rise per metre along world x, and along y
            as the imaginary part.
        speeds: of the centres of the left and of the right sole, m/s.
        tilt: angle from the vertical of what is vertical on the body in the nominal posture, rad,
            and its rate, rad/s.
        base: world height of the base, m, and its vertical velocity, m/s.
    """

    def __init__(self, robot: Robot, kin: Kinematics) -> None:
        self._kin = kin
        self._body = np.zeros(1, BODY)
        body = self._body[0]
        body["mass"], body["weight"], body["gravity"] = kin.mass, robot.weight, robot.gravity
        for k, sole in enumerate(robot.soles):
            body["joint"][k] = sole.joint_id
            body["axis"][k] = sole.placement.rotation[:, 0]
            body["normal"][k] = sole.placement.rotation[:, 2]
            body["position"][k] = sole.placement.translation
        body["up"] = pin.Quaternion(robot.q_nominal[3:7]).matrix()[2]
        self.slopes = (0j, 0j)
        self.speeds = (0.0, 0.0)
        self.tilt = self.base = (0.0, 0.0)

    def read(self) -> tuple[Feet, CentroidalMotion]:
        """Return both soles and the motion of the centre of mass, world axes."""
        kin = self._kin
        left, right, com, self.slopes, self.speeds, self.tilt, self.base = read_ground(
            kin.joint_placements, kin.joint_velocities, kin.mass_matrix, kin.state.v, self._body
        )
        # The kernel's tuples have the fields in order: no need to unpack them.
        feet = Feet(_from_tuple(Placement, left), _from_tuple(Placement, right))
        return feet, _from_tuple(CentroidalMotion, com)
