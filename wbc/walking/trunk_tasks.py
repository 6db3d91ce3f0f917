"""The trunk is held upright, or leant as a motion says."""

from __future__ import annotations

from wbc.controller import WholeBodyController
from wbc.kinematics import Kinematics
from wbc.tasks import OrientationTask
from wbc.walking.contact_manager import rotation_about_z
from wbc.walking.gains import WalkerGains
from wbc.walking.reference_offset import ReferenceOffset


class TrunkTasks:
    """Orientation tasks of torso and base (one task where these are one link).

    Args:
        controller: that gets the tasks.
        kin: standing upright, heading along x.
        gains: weight and gain.

    Attributes:
        tasks: of the torso, then of the base.
    """

    def __init__(
        self, controller: WholeBodyController, kin: Kinematics, gains: WalkerGains
    ) -> None:
        frames = dict.fromkeys((controller.robot.torso, controller.robot.base))
        self.tasks = tuple(
            controller.add(OrientationTask(name, weight=gains.trunk_weight, kp=gains.trunk_kp))
            for name in frames
        )
        self._upright = [kin.frame(name).rotation.copy() for name in frames]

    def update(self, yaw: float, rate: float, offset: ReferenceOffset | None) -> None:
        """Upright, along a heading.

        Args:
            yaw: rad.
            rate: rad/s.
            offset: by how much a motion leans it; None: not at all.
        """
        heading = rotation_about_z(yaw)
        for task, upright in zip(self.tasks, self._upright, strict=True):
            task.target = heading.dot(upright)
            task.velocity[2] = rate
        if offset is None:
            return
        attitudes = (offset.torso, offset.base)[-len(self.tasks) :]
        for task, upright, attitude in zip(self.tasks, self._upright, attitudes, strict=True):
            if attitude.is_zero:
                task.velocity[:2] = 0.0
                task.acceleration[:] = 0.0
                continue
            rotation, velocity, acceleration = attitude.motion()
            task.target = heading @ rotation @ upright
            task.velocity = heading @ velocity
            task.velocity[2] += rate
            task.acceleration = heading @ acceleration
