"""Tasks and contacts of a quadruped in the QP."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from wbc.contacts import PointContact
from wbc.controller import WholeBodyController
from wbc.gait import SwingFoot
from wbc.kinematics import Kinematics
from wbc.tasks import ComTask, PostureTask, Task
from wbc.walking.gains import WalkerGains
from wbc.walking.reference_offset import ReferenceOffset
from wbc.walking.swing_task import SwingTask
from wbc.walking.trunk_tasks import TrunkTasks


class QuadrupedTasks:
    """Centre of mass, trunk, posture, feet in the air, and a point contact for every other foot.

    The contacts' motion has a high weight: four feet held exactly, and legs at their torque limits
    after a push, may have no solution.

    Args:
        controller: gets tasks and contacts.
        kin: standing upright, heading along x; whoever owns it updates it.
        gains: weights and gains.

    Attributes:
        com: centre of mass.
        posture: all actuated joints.
    """

    def __init__(
        self, controller: WholeBodyController, kin: Kinematics, gains: WalkerGains
    ) -> None:
        robot, kp = controller.robot, gains.height_kp
        self._controller, self._kin, self._robot = controller, kin, robot
        self._com_target = np.zeros(3)
        self.com = controller.add(
            ComTask(
                self._com_target,
                weight=gains.com_weight,
                kp=np.array([0.0, 0.0, kp]),
                kd=np.array([0.0, 0.0, 2.0 * math.sqrt(kp)]),
            )
        )
        self._trunk = TrunkTasks(controller, kin, gains)
        weights = np.full(robot.na, gains.posture_weight)
        for leg in robot.legs:
            weights[np.array(leg) - 6] = gains.leg_posture_weight
        self.posture = controller.add(PostureTask(robot, weight=weights, kp=gains.posture_kp))
        self._contacts: dict[str, PointContact] = {}
        self._swings: dict[str, SwingTask] = {}
        place_only = np.array([gains.swing_weight] * 3 + [0.0] * 3)
        for sole in robot.soles:
            # Its axes are the world's: the foot turns about the point on which it stands.
            contact = PointContact(
                sole.name,
                friction=gains.friction,
                motion_weight=gains.second_contact_weight,
                placement=pin.SE3.Identity(),
            )
            contact.bind(robot)
            self._contacts[sole.side] = contact
            self._swings[sole.side] = SwingTask(sole.name, weight=place_only, kp=gains.swing_kp)

    @property
    def tasks(self) -> tuple[Task, ...]:
        """All tasks; the controller has those of the feet in the air."""
        return (self.com, *self._trunk.tasks, self.posture, *self._swings.values())

    def update_balance(
        self,
        com_acceleration: complex,
        height: float,
        heading: float,
        yaw_rate: float,
        offset: ReferenceOffset | None,
    ) -> None:
        """Set the references of centre of mass and trunk.

        Args:
            com_acceleration: horizontal acceleration of the CoM, world axes, m/s².
            height: height of the CoM, world, m.
            heading: rad.
            yaw_rate: rad/s.
            offset: what a motion adds; None: nothing.
        """
        com = self.com
        com.acceleration[0], com.acceleration[1] = com_acceleration.real, com_acceleration.imag
        velocity = acceleration = 0.0
        if offset is not None:
            height += offset.com[2]
            velocity, acceleration = offset.com_velocity[2], offset.com_acceleration[2]
        com.velocity[2], com.acceleration[2] = velocity, acceleration
        self._com_target[2] = height
        com.target = self._com_target
        self._trunk.update(heading, yaw_rate, offset)

    def update_feet(self, swings: Mapping[str, SwingFoot], max_forces: Mapping[str, float]) -> None:
        """Follow the feet in the air with a task, and hold the others by contacts.

        Args:
            swings: side -> reference of a foot in the air.
            max_forces: side -> largest normal force, N; infinite when left out.
        """
        contacts = []
        for side, task in self._swings.items():
            swing = swings.get(side)
            if (swing is None) is not (task.foot is None):
                if swing is None:
                    self._controller.remove(task)
                else:
                    self._controller.add(task)
            task.foot = swing
            if swing is None:
                contact = self._contacts[side]
                turned = self._kin.frame(contact.frame_id).rotation
                contact.placement = pin.SE3(turned.T, np.zeros(3))
                contact.max_force = max_forces.get(side, math.inf)
                contacts.append(contact)
        if tuple(contacts) != self._controller.contacts:  # which checks what it is given
            self._controller.contacts = contacts
