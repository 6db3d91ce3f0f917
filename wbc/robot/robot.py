"""`Robot`: a Pinocchio model with what a whole-body controller needs to know about it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.errors import FrameNotFound
from wbc.robot.finding import Finding
from wbc.robot.robot_model import RobotModel
from wbc.robot.soles import Side, Sole
from wbc.state import State


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Robot(RobotModel):
    """A humanoid with a floating base and two soles; made by `load`.

    Its model has the frames `left_sole` and `right_sole`. In `q_nominal` it stands: soles on
    z = 0, their midpoint at the origin, heading +x.

    Attributes:
        soles: left and right.
        torso: name of the upper trunk's link (a frame of the model).
        imu: name of the frame where the inertial unit sits.
        legs: velocity indices (into nv) of the joints that move the left and the right sole
            alone, from the hip down.
    """

    soles: tuple[Sole, Sole]
    torso: str
    imu: str
    legs: tuple[tuple[int, ...], tuple[int, ...]]

    def __repr__(self) -> str:
        left, right = self.soles
        return (
            f"Robot('{self.name}', {self.na} joints, {self.mass:.1f} kg, "
            f"soles {left.size_text} on '{left.link}' and '{right.link}')"
        )

    @cached_property
    def com_height(self) -> float:
        """Height of the centre of mass above the soles in the nominal posture, m."""
        return float(pin.centerOfMass(self.model, self.model.createData(), self.q_nominal)[2])

    @cached_property
    def leg_length(self) -> float:
        """Length of the stretched leg from its first joint to the sole, m (mean of both)."""
        lengths = []
        for sole in self.soles:
            hip = self._leg_chain(sole)
            lengths.append(
                sum(
                    float(np.linalg.norm(self.model.jointPlacements[j].translation))
                    for j in hip[1:]
                )
                + float(np.linalg.norm(sole.placement.translation))
            )
        return float(np.mean(lengths))

    def sole(self, name: str) -> Sole:
        """The sole of that name (`left_sole`, `right_sole`) or side (`left`, `right`).

        Raises:
            FrameNotFound: no sole is called so.
        """
        for sole in self.soles:
            if name in (sole.name, sole.side):
                return sole
        raise FrameNotFound(name, [sole.name for sole in self.soles], "Robot.sole")

    def leg_joints(self, side: Side) -> tuple[int, ...]:
        """Velocity indices (into nv) of the joints that move one sole alone, hip first."""
        return self.legs[self.soles.index(self.sole(side))]

    def standing(self) -> State:
        """The nominal posture at rest: soles on z = 0, midpoint at the origin, heading +x."""
        return State(self.q_nominal.copy(), np.zeros(self.nv))

    def check(self) -> list[Finding]:
        """Everything that is wrong with the robot's description, worst first."""
        from wbc.robot.doctor import check_robot

        return check_robot(self)

    def _leg_chain(self, sole: Sole) -> list[int]:
        leg = self.legs[self.soles.index(sole)]
        return [j for j in self.model.supports[sole.joint_id] if self.model.joints[j].idx_v in leg]
