"""`Robot`: a Pinocchio model with what a whole-body controller needs to know about it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.errors import FrameNotFound, WbcError, short_repr
from wbc.robot.finding import Finding
from wbc.robot.posture import has_soles
from wbc.robot.robot_model import RobotModel
from wbc.robot.soles import Side, Sole
from wbc.state import State

_POINT_LEG = 3  # joints that place a foot but do not turn it


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Robot(RobotModel):
    """A humanoid or a quadruped: a floating base and two or four soles; made by `load`.

    Its model has a frame for each sole, such as `left_sole`. In `q_nominal` it stands: soles on
    z = 0, their midpoint at the origin, heading +x.

    Attributes:
        soles: left and right; of a quadruped front left, front right, hind left, hind right.
        torso: name of the upper trunk's link (a frame of the model).
        imu: name of the frame where the inertial unit sits.
        legs: per sole, velocity indices (into nv) of the joints that move it alone, from the
            hip down.
    """

    soles: tuple[Sole, ...]
    torso: str
    imu: str
    legs: tuple[tuple[int, ...], ...]

    def __repr__(self) -> str:
        *others, last = (f"'{sole.link}'" for sole in self.soles)
        return (
            f"Robot('{self.name}', {self.na} joints, {self.mass:.1f} kg, "
            f"soles {self.soles[0].size_text} on {', '.join(others)} and {last})"
        )

    @property
    def is_quadruped(self) -> bool:
        """Whether it stands on four feet."""
        return len(self.soles) > 2

    @cached_property
    def point_feet(self) -> tuple[bool, ...]:
        """Per sole, whether it touches the ground at a point.

        A foot without area does, and one on a leg of three joints, which cannot keep it flat.
        """
        return tuple(
            len(leg) <= _POINT_LEG or not has_soles((sole,))
            for sole, leg in zip(self.soles, self.legs, strict=True)
        )

    @cached_property
    def com_height(self) -> float:
        """Height of the centre of mass above the soles in the nominal posture, m."""
        return float(pin.centerOfMass(self.model, self.model.createData(), self.q_nominal)[2])

    @cached_property
    def leg_length(self) -> float:
        """Length of the stretched leg from its first joint to the sole, m (mean of all)."""
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
        """The sole of that name (`left_sole`, …) or side (`left`, …).

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


def checked_robot(robot: object, user: str) -> Robot:
    """Return a robot on feet.

    Args:
        robot: what was given.
        user: who needs it, for the message.

    Raises:
        WbcError: it is something else, e.g. a robot whose base is fixed, or a name.
    """
    if isinstance(robot, Robot):
        return robot
    if isinstance(robot, RobotModel):
        raise WbcError(
            f"{user} is for robots on feet, and the base of '{robot.name}' is fixed; "
            "wbc.InverseKinematics moves it"
        )
    raise WbcError(f"{user} takes a robot, such as wbc.load('talos'), not {short_repr(robot)}")
