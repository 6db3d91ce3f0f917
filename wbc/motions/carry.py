"""Carry: a payload of unknown mass in a hand, standing and walking."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pinocchio as pin

from wbc.errors import MotionError
from wbc.motions.engine import Motion, MotionContext, Script, check_positive, parameter
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

_TORQUE_SHARE = 0.9  # of the limits that carrying may use
_REST = 1.5  # s before and after the payload is walked with


@dataclass(frozen=True)
class Carry(Motion):
    """Carry a payload whose mass the robot does not know: it is estimated, and counted on.

    The forces on the feet tell the mass; without sensors there, the torques of the arm. The arm
    bears the weight, and the balance moves the centre of mass of the robot against it. A simulated
    robot gets the payload at the beginning, and gives it away at the end.
    """

    name: ClassVar[str] = "carry"
    summary: ClassVar[str] = "carry a payload of unknown mass in a hand, and walk with it"

    hand: str = parameter("left", "hand that carries", choices=("left", "right"))
    mass: float = parameter(2.0, "mass of the payload, only in simulation, kg")
    walk: float = parameter(0.2, "forward velocity, m/s; 0 to stand")
    seconds: float = parameter(5.0, "time of walking, s")

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "mass", "seconds")
        most, joint = _max_payload(robot, self.hand)
        if self.mass > most:
            raise MotionError(
                f"carry: {self.mass:g} kg is more than the {self.hand} arm of {robot.name} bears "
                f"as it hangs: {most:.1f} kg, by the torque of '{joint}'"
            )

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        hands = context.hand_contacts
        hands.carry(self.hand)
        yield from context.wait(_REST)
        context.request_payload(self.hand, self.mass)
        yield from context.until(lambda: hands.payload_settled(self.hand))
        context.note(f"the payload in the {self.hand} hand has {hands.payload(self.hand):.2f} kg")
        if self.walk:
            context.feet.walk((self.walk, 0.0, 0.0))
            yield from context.wait(self.seconds)
            context.feet.walk((0.0, 0.0, 0.0))
            yield from context.until(lambda: context.standing)
        yield from context.wait(_REST)
        context.note(f"after walking: {hands.payload(self.hand):.2f} kg")
        context.request_payload(self.hand, 0.0)
        yield from context.wait(_REST)


def _max_payload(robot: Robot, side: str) -> tuple[float, str]:
    """Return the mass that a hanging arm bears, kg, and the joint that limits it."""
    model, data = robot.model, robot.model.createData()
    arm = UpperBody.of(robot).arm(side)
    joints = np.array(arm.joints)
    pin.computeGeneralizedGravity(model, data, robot.q_nominal)
    pin.computeJointJacobians(model, data, robot.q_nominal)
    frame = robot.frame_id(arm.hand)
    J = pin.getFrameJacobian(model, data, frame, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)
    per_kg = robot.gravity * J[2, 6 + joints]
    room = _TORQUE_SHARE * robot.tau_max[joints] - np.sign(per_kg) * data.g[6 + joints]
    masses = np.maximum(room, 0.0) / np.maximum(np.abs(per_kg), 1e-9)
    least = int(np.argmin(masses))
    return float(masses[least]), robot.joint_names[joints[least]]
