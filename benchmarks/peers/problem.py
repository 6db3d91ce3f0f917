"""States the problem of a case as a `wbc.WholeBodyController`."""

from __future__ import annotations

import math
from dataclasses import dataclass

import wbc
from peers.case import LEFT, RIGHT, SOLES, STANCES, Gains, Limits
from wbc.limits import JointPositionLimit, JointVelocityLimit, TorqueLimit
from wbc.qp import Regularisation

ACCELERATION_WEIGHT = 1e-8  # TSID and placo add it to every unknown


@dataclass(frozen=True)
class Tasks:
    """The controller of one set of standing feet, and its tasks whose references change."""

    controller: wbc.WholeBodyController
    com: wbc.ComTask
    torso: wbc.OrientationTask
    swing: wbc.FrameTask | None


@dataclass(frozen=True)
class Problem:
    """The common parts of a case's controllers.

    Attributes:
        friction: coefficient of the pyramid.
        posture: (na,) rad.
        momentum: whether there is a task for the angular momentum.
        contact: class of the contacts.
    """

    robot: wbc.Robot
    limits: Limits
    gains: Gains
    half_length: float
    half_width: float
    friction: float
    posture: object
    momentum: bool = True
    contact: type[wbc.SurfaceContact] = wbc.SurfaceContact

    def controller(self, stance: int, dt: float = 0.002) -> Tasks:
        """Return the controller for one set of standing feet."""
        robot, gains, limits = self.robot, self.gains, self.limits
        how = {"braking": limits.braking, "horizon": limits.horizon}
        controller = wbc.WholeBodyController(
            robot,
            dt,
            limits=(
                TorqueLimit(robot, limits.torque),
                JointPositionLimit(robot, margin=0.0, **how),
                JointVelocityLimit(robot, limits.velocity, **how),
            ),
            regularisation=Regularisation(
                force=gains.force_weight, acceleration=ACCELERATION_WEIGHT
            ),
        )
        add = controller.add
        com = add(wbc.ComTask(weight=gains.com_weight, kp=gains.com_kp))
        torso = add(wbc.OrientationTask(robot.torso, weight=gains.torso_weight, kp=gains.torso_kp))
        add(wbc.PostureTask(robot, self.posture, weight=gains.posture_weight, kp=gains.posture_kp))
        if self.momentum:
            add(wbc.AngularMomentumTask(weight=gains.momentum_weight, kp=gains.momentum_kp))
        swing = None
        if stance in (LEFT, RIGHT):
            free = SOLES["right" if stance == LEFT else "left"]
            swing = add(wbc.FrameTask(free, weight=gains.swing_weight, kp=gains.swing_kp))
        controller.set_contacts(
            [
                self.contact(
                    SOLES[side],
                    self.half_length,
                    self.half_width,
                    friction=self.friction * math.sqrt(2.0),
                    damping=gains.contact_damping,
                )
                for side in STANCES[stance]
            ]
        )
        return Tasks(controller, com, torso, swing)
