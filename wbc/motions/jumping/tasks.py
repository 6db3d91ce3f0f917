"""Tasks, contacts and limits of a jump, in a whole-body controller of its own."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
import pinocchio as pin

from wbc.command import Command
from wbc.contacts import SurfaceContact
from wbc.controller import WholeBodyController
from wbc.geometry.planar import rotation_about_z
from wbc.kinematics import Kinematics
from wbc.limits import JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.motions.jumping.gains import JumpGains
from wbc.qp import Solver
from wbc.robot import Robot
from wbc.tasks import AngularMomentumTask, ComTask, FrameTask, OrientationTask, PostureTask


class JumpTasks:
    """The tasks of CoM, trunk, soles and posture for a robot that stands, flies or lands.

    Args:
        robot: the robot.
        standing: kinematics of the robot when standing.
        dt: control period, s.
        gains: weights and gains.
        solver: QP solver by name.

    Attributes:
        controller: the whole-body controller.
        com: task of the CoM; its weight is 0 in the air.
        posture: task of all joints.
        soles: side -> pose task of the sole while it is in the air.
    """

    def __init__(
        self,
        robot: Robot,
        standing: Kinematics,
        dt: float,
        gains: JumpGains,
        solver: str | Solver | None = None,
    ) -> None:
        self._gains = gains
        self.controller = controller = WholeBodyController(
            robot, dt, solver=solver, limits=_limits(standing, gains.braking)
        )
        kp = np.array([0.0, 0.0, gains.height_kp])
        self.com = controller.add(
            ComTask(np.zeros(3), weight=gains.com_weight, kp=kp, kd=2.0 * np.sqrt(kp))
        )
        self._trunk = []
        for column, frame in enumerate((robot.torso, robot.base)):
            if column and frame == robot.torso:
                continue
            task = OrientationTask(frame, weight=gains.trunk_weight, kp=gains.trunk_kp)
            upright = standing.frame(frame).rotation.copy()
            self._trunk.append((controller.add(task), upright, column))
        weights = np.full(robot.na, gains.posture_weight)
        for leg in robot.legs:
            weights[np.array(leg) - 6] = gains.leg_posture_weight
        self.posture = controller.add(PostureTask(robot, weight=weights, kp=gains.posture_kp))
        controller.add(AngularMomentumTask(weight=gains.momentum_weight))
        self.soles: dict[str, FrameTask] = {}
        self._contacts: dict[str, SurfaceContact] = {}
        for sole in robot.soles:
            contact = SurfaceContact.from_sole(
                sole, margin=gains.sole_margin, friction=gains.friction
            )
            self._contacts[sole.side] = contact
            self.soles[sole.side] = FrameTask(sole.name, weight=gains.sole_weight, kp=gains.sole_kp)

    def stand_on(self, sides: Collection[str]) -> None:
        """Put the soles of these sides on the ground, the others in the air."""
        controller, gains = self.controller, self._gains
        for side, task in self.soles.items():
            in_air = side not in sides
            if in_air and task not in controller.tasks:
                controller.add(task)
            elif not in_air and task in controller.tasks:
                controller.remove(task)
        contacts = [contact for side, contact in self._contacts.items() if side in sides]
        for k, contact in enumerate(contacts):
            contact.motion_weight = gains.second_contact_weight if k else None
        controller.contacts = contacts
        self.com.weight = gains.com_weight if contacts else 0.0

    def set_trunk_pitch(self, heading: float, pitch: np.ndarray) -> None:
        """Set the references of the trunk's orientation.

        Args:
            heading: heading of the robot, rad.
            pitch: (3, 2) pitch, rate and acceleration of torso and base; rad, s.
        """
        turned = rotation_about_z(heading)
        for task, upright, column in self._trunk:
            angle, rate, acceleration = pitch[:, column]
            task.target = turned @ pin.exp3(np.array([0.0, angle, 0.0])) @ upright
            task.velocity = rate * turned[:, 1]
            task.acceleration = acceleration * turned[:, 1]

    def set_posture(self, posture: np.ndarray) -> None:
        """Set the references of joint positions, velocities, accelerations, (3, na)."""
        self.posture.target, self.posture.velocity, self.posture.acceleration = posture

    def solve(self, kin: Kinematics) -> Command:
        """Compute the command of one tick."""
        return self.controller.solve(kin)


def _limits(
    standing: Kinematics, most: float
) -> tuple[TorqueLimit, JointPositionLimit, JointVelocityLimit]:
    robot, inertia = standing.robot, np.diag(standing.mass_matrix)[6:]
    braking = np.minimum(most, 0.5 * robot.tau_max / inertia)
    return (
        TorqueLimit(robot),
        JointPositionLimit(robot, braking=braking),
        JointVelocityLimit(robot, braking=braking),
    )
