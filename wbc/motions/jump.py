"""Jump: off the ground with both feet, and back onto them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from wbc.motions.engine import (
    Motion,
    MotionContext,
    Script,
    check_positive,
    once_per_robot,
    parameter,
)
from wbc.motions.jumping import JumpController, JumpPlan, plan_jump
from wbc.robot import Robot


@dataclass(frozen=True)
class Jump(Motion):
    """Crouch, push off, fly, land, and stand again.

    The height is planned from the robot's limits of torque, joint velocity and joint position;
    a robot whose limits do not allow it is refused, with the bound and the joint that sets it.
    """

    name: ClassVar[str] = "jump"
    summary: ClassVar[str] = "jump on the spot, as high as asked within the robot's limits"

    clearance: float = parameter(0.05, "height of both soles over the ground at the apex, m")

    @once_per_robot
    def plan(self, robot: Robot) -> JumpPlan:
        """Return the plan for a robot; the first call takes about a second.

        Raises:
            JumpTooHigh: the jump is beyond the robot's limits; with the bound.
            MotionError: the clearance is not positive, or the legs cannot jump at all.
        """
        return plan_jump(robot, self.clearance)

    def check(self, robot: Robot) -> None:
        """See `Motion.check`."""
        check_positive(self, "clearance")
        self.plan(robot)

    def play(self, context: MotionContext) -> Script:
        """See `Motion.play`."""
        plan = self.plan(context.robot)
        solver = context.walker.controller.solver
        controller = JumpController(context.robot, plan, context.dt, solver=solver)
        yield  # making the controller takes a tick, and so does its first step
        yield from context.until(lambda: context.standing)
        yield from context.feet.until_settled()
        assert context.state is not None
        controller.reset(context.state)
        context.start_override(controller)
        yield from context.until(lambda: controller.done)
        context.resume_walker()
        yield from context.until(lambda: context.at_home)
        context.note(
            f"planned: the CoM rises {1e3 * plan.rise:.0f} mm after leaving the ground with "
            f"{plan.speed:.2f} m/s, both soles clear {1e3 * plan.clearance:.0f} mm; it takes "
            f"{100.0 * plan.torque_share:.0f} % of the torque of '{plan.torque_joint}' and "
            f"{100.0 * plan.speed_share:.0f} % of the velocity of '{plan.speed_joint}'"
        )
