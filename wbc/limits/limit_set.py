"""A controller's limits, checked and sorted by what the QP makes of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from wbc.errors import LimitError, short_repr
from wbc.limits.acceleration import JointAccelerationLimit
from wbc.limits.acceleration_bound import AccelerationBound
from wbc.limits.barrier import BarrierLimit
from wbc.limits.jerk import JointJerkLimit
from wbc.limits.limit import Limit
from wbc.limits.position import JointPositionLimit
from wbc.limits.torque import TorqueLimit
from wbc.robot import RobotModel

AnyLimit: TypeAlias = Limit | AccelerationBound | TorqueLimit

_ACCEPTED = (
    "a TorqueLimit, a limit on joints (derived from wbc.limits.AccelerationBound: position, "
    "velocity, acceleration) or rows of your own (derived from wbc.limits.Limit)"
)


@dataclass(frozen=True, eq=False)
class LimitSet:
    """The limits of a controller by kind, compared by identity.

    Attributes:
        torque: limit on the joint torques, or None.
        bounds: limits on single joints, which become simple bounds; where they exclude each
            other, the first holds: those on velocities and accelerations, then positions (a joint
            beyond its range comes back as fast as it may), then jerks.
        inequalities: general limits, which become rows.
    """

    torque: TorqueLimit | None
    bounds: tuple[AccelerationBound, ...]
    inequalities: tuple[Limit, ...]

    @property
    def barriers(self) -> tuple[str, ...]:
        """Names of the exact barriers, which give way where all rows cannot hold."""
        return tuple(
            [b.name for b in self.inequalities if isinstance(b, BarrierLimit) and not b.priority]
        )

    @classmethod
    def sort(cls, limits: Sequence[AnyLimit], robot: RobotModel, dt: float) -> LimitSet:
        """Check limits and bind them to a robot.

        Args:
            limits: limits, in any order.
            robot: the robot.
            dt: control period, s.

        Raises:
            LimitError: something that is no limit, two torque limits, two general limits of one
                name, a limit of another robot, a horizon that is shorter than dt, or a braking
                of the position limit that an acceleration limit does not allow.
        """
        if isinstance(limits, AnyLimit) or not isinstance(limits, Sequence):
            raise LimitError(f"limits = {short_repr(limits)} is no sequence; write limits=[…]")
        for limit in limits:
            if not isinstance(limit, AnyLimit):
                kind = limit.__name__ if isinstance(limit, type) else type(limit).__name__
                raise LimitError(
                    f"{short_repr(limit)} ({kind}) is not a limit that a controller understands: "
                    f"give it {_ACCEPTED}"
                )
        torque = [limit for limit in limits if isinstance(limit, TorqueLimit)]
        bounds = tuple(
            sorted((b for b in limits if isinstance(b, AccelerationBound)), key=_precedence)
        )
        inequalities = tuple(limit for limit in limits if isinstance(limit, Limit))
        if len(torque) > 1:
            raise LimitError("more than one TorqueLimit given; keep the tighter one")
        if torque and torque[0].maximum.size != robot.na:
            raise LimitError(
                f"the torque limit is of a robot with {torque[0].maximum.size} joints, "
                f"'{robot.name}' has {robot.na}; make it with TorqueLimit(robot)"
            )
        for bound in bounds:
            if 0.0 < bound.horizon < dt:
                raise LimitError(
                    f"{bound.name}: its horizon {bound.horizon} s is shorter than the control "
                    f"period {dt} s, so it would overshoot; give it at least that"
                )
        _check_braking(bounds, robot)
        names = [limit.name for limit in inequalities]
        for name in names:
            if names.count(name) > 1:
                raise LimitError(f"two limits are named '{name}'; give one another name")
        for limit in inequalities:
            limit.bind(robot)
        return cls(torque[0] if torque else None, bounds, inequalities)


def _precedence(bound: AccelerationBound) -> int:
    return 2 * isinstance(bound, JointJerkLimit) + isinstance(bound, JointPositionLimit)


def _check_braking(bounds: Sequence[AccelerationBound], robot: RobotModel) -> None:
    """Check that joints may brake as hard as the limit on their positions relies on."""
    for position in bounds:
        for acceleration in bounds:
            if not isinstance(position, JointPositionLimit):
                continue
            if not isinstance(acceleration, JointAccelerationLimit):
                continue
            short = np.flatnonzero(position.braking > acceleration.maximum * (1.0 + 1e-9))
            if short.size:
                worst = int(short[0])
                raise LimitError(
                    f"the joint position limit counts on braking '{robot.joint_names[worst]}' with "
                    f"{position.braking[worst]:.3g} rad/s², of which the joint acceleration limit "
                    f"allows {acceleration.maximum[worst]:.3g}; give JointPositionLimit(robot, "
                    "braking=…) at most that"
                )
