"""References of the soles while the robot is in the air."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from wbc.geometry.planar import ground_point, rotation_about_z, yaw_of
from wbc.kinematics import Kinematics
from wbc.motions.jumping.plan import JumpPlan
from wbc.motions.jumping.profile import HeightState, MinimumJerk
from wbc.tasks import FrameTask


class SoleFlightReference:
    """Moves the soles from where they leave the ground to where they will catch the CoM.

    Duration and landing place follow from the CoM as it takes off: it flies for
    `T = (ż + √(ż² + 2 g Δz)) / g`, Δz being its height above that of touchdown, and lands with
    its DCM at `c + ċ (T + 1/ω)`: with the soles there it comes to rest above them.

    Args:
        plan: plan of the jump.
        kin: kinematics at take-off.
        soles: side -> pose task of the sole.
        ground: height of the ground, m.
        min_duration: least duration, s.
        reach: greatest distance of the soles from below the CoM, m.
    """

    def __init__(
        self,
        plan: JumpPlan,
        kin: Kinematics,
        soles: Mapping[str, FrameTask],
        ground: float,
        min_duration: float,
        reach: float,
    ) -> None:
        self._gravity = g = plan.path.robot.gravity
        self._soles = soles
        self._ground = ground
        self._reach = reach
        v = float(kin.v_com[2])
        above = float(kin.p_com[2]) - ground - plan.take_off
        duration = (v + math.sqrt(max(v * v + 2.0 * g * above, 0.0))) / g
        self._height = replace(plan.flight, duration=max(duration, min_duration))
        self._start = {side: kin.frame(task.frame).copy() for side, task in soles.items()}
        places = [start.translation for start in self._start.values()]
        self._middle = ground_point(sum(places) / len(places))
        self._catch_time = math.sqrt(plan.take_off / g)

    @property
    def duration(self) -> float:
        """Time from take-off to touchdown, s."""
        return self._height.duration

    def write_reference(self, kin: Kinematics, time: float) -> HeightState:
        """Write the soles' references at a time since take-off, s.

        The landing place follows from the present CoM.

        Returns:
            Height of the CoM above the soles, m, its velocity and acceleration: measured CoM,
            reference of the soles.
        """
        height, rate, acceleration = self._height.at(time)
        left = max(self.duration - time, 0.0)
        shift = (
            ground_point(kin.p_com)
            + ground_point(kin.v_com) * (left + self._catch_time)
            - self._middle
        )
        shift *= min(1.0, self._reach / max(abs(shift), 1e-9))
        progress = MinimumJerk(0.0, 1.0, self.duration).at(time)
        for side, task in self._soles.items():
            start = self._start[side]
            x, y = start.translation[:2]
            place = np.array(
                [x + progress[0] * shift.real, y + progress[0] * shift.imag, self._ground + height]
            )
            yaw = yaw_of(start.rotation)
            task.target = pin.SE3(rotation_about_z(yaw), place)
            task.velocity[:3] = progress[1] * shift.real, progress[1] * shift.imag, rate
            task.acceleration[:3] = progress[2] * shift.real, progress[2] * shift.imag, acceleration
        above = float(kin.p_com[2]) - self._ground - height
        return above, float(kin.v_com[2]) - rate, -self._gravity - acceleration
