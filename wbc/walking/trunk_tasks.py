"""Orientation tasks that hold the trunk upright, or where a motion turns it."""

from __future__ import annotations

import math

import numpy as np

from wbc.controller import WholeBodyController
from wbc.geometry.planar import rotation_about_z
from wbc.kinematics import Kinematics
from wbc.tasks import OrientationTask
from wbc.walking.gains import WalkerGains
from wbc.walking.kernels.trunk import turn_about_z
from wbc.walking.reference_offset import ReferenceOffset


class TrunkTasks:
    """Orientation tasks of torso and base (one task where these are one link).

    Args:
        controller: controller that gets the tasks.
        kin: standing upright, heading along x.
        gains: weight and gain.

    Attributes:
        tasks: tasks of the torso, then of the base.
    """

    def __init__(
        self, controller: WholeBodyController, kin: Kinematics, gains: WalkerGains
    ) -> None:
        frames = dict.fromkeys((controller.robot.torso, controller.robot.base))
        self.tasks = tuple(
            controller.add(OrientationTask(name, weight=gains.trunk_weight, kp=gains.trunk_kp))
            for name in frames
        )
        self._kin, self._torso = kin, controller.robot.torso
        self._upright = np.array([kin.frame(name).rotation for name in frames])
        self._targets = self._upright.copy()

    def update(self, yaw: float, yaw_rate: float, offset: ReferenceOffset | None) -> None:
        """Set the references: upright along a heading, turned by an offset.

        Args:
            yaw: heading, rad.
            yaw_rate: rad/s.
            offset: rotation that a motion adds; None: nothing.
        """
        turn_about_z(yaw, self._upright, self._targets)
        for k, task in enumerate(self.tasks):
            task.target = self._targets[k]
            task.velocity[2] = yaw_rate
        if offset is None:
            return
        heading = rotation_about_z(yaw)
        rotations = (offset.torso, offset.base)[-len(self.tasks) :]
        for task, upright, added in zip(self.tasks, self._upright, rotations, strict=True):
            if added.is_zero:
                task.velocity[:2] = 0.0
                task.acceleration[:] = 0.0
                continue
            rotation, velocity, acceleration = added.motion()
            task.target = heading @ rotation @ upright
            task.velocity = heading @ velocity
            task.velocity[2] += yaw_rate
            task.acceleration = heading @ acceleration

    def torso_turn(self) -> float:
        """Return the angle of the torso from its reference about the vertical, rad.

        It is 0 where the torso is the base, which has no waist to turn on.
        """
        target = self.tasks[0].target
        if target is None or len(self.tasks) == 1:
            return 0.0
        turned = self._kin.frame(self._torso).rotation @ target.T
        return math.atan2(turned[1, 0] - turned[0, 1], turned[0, 0] + turned[1, 1])
