"""The command that a controller returns each tick."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from wbc.errors import WbcError
from wbc.servo import ServoCommand, ServoGains

if TYPE_CHECKING:
    from wbc.qp import TickExplanation


class Status(Enum):
    """Outcome of the tick's QP."""

    OK = "ok"  #: solved to optimality
    INFEASIBLE = "infeasible"  #: there is no solution: safe torques; `explanation` names the rows
    FAILED = "failed"  #: the solver failed or an input is not finite: safe torques


class CommandSource(Protocol):
    """A controller that can explain its last command, and record what it was made of."""

    def explain(self, command: Command) -> TickExplanation:
        """Explain a command; see `Command.explain`."""

    def packed_inputs(self, command: Command, words: int) -> np.ndarray:
        """Return what a command's QP was made of, (words,); see `wbc.qp.inputs`."""


@dataclass(frozen=True, slots=True, repr=False)
class Command:
    """The output of one tick: always finite, torques always within limits.

    Attributes:
        tau: (na,) joint torques, N·m (N for prismatic joints), model joint order.
        acceleration: (nv,) generalised acceleration that the torques produce if
            the model is right, m/s² and rad/s², base in the base frame.
        wrenches: contact name -> (6,) force then moment exerted by the ground
            on the robot, at the contact's centre, in contact axes; N, N·m
            (a point contact has zero moment).
        q_target: (na,) joint positions one control period ahead, rad.
        v_target: (na,) joint velocities one control period ahead, rad/s.
        status: outcome of the QP.
        explanation: which rows conflict; when `status` is OK, which barriers give way (see
            `wbc.limits.BarrierLimit`), empty for none.
        source: controller whose QP it comes from; None when it comes from no QP, and in copies.
    """

    tau: np.ndarray
    acceleration: np.ndarray
    wrenches: dict[str, np.ndarray]
    q_target: np.ndarray
    v_target: np.ndarray
    status: Status = Status.OK
    explanation: str = ""
    source: CommandSource | None = field(default=None, repr=False, compare=False)

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy everything but the source, whose QP a copy does not belong to."""
        parts = (self.tau, self.acceleration, self.wrenches, self.q_target, self.v_target)
        return Command, (*parts, self.status, self.explanation)

    def explain(self) -> TickExplanation:
        """Explain this command: what tasks asked for and got, and which rows stood in their way.

        When there is no solution, it names the rows in conflict and by how much each has to give
        way. It takes some milliseconds, outside of the tick. Commands of a log are
        explained by `wbc.log.LoggedTick`.

        Raises:
            WbcError: the command comes from no QP, or is not the last one of its controller, whose
                QP is overwritten by each tick.
        """
        if self.source is None:
            raise WbcError(
                "this command cannot be explained: it was copied, or comes from no QP (a fall, a "
                "learned policy)"
            )
        return self.source.explain(self)

    def servo(self, gains: ServoGains) -> ServoCommand:
        """Return this command for joint servos with such gains.

        Their positions and velocities are `q_target` and `v_target`, one control period ahead of
        the measured ones, and their feed-forward torques `tau`: at rest and without disturbances
        the servos exert `tau`. A `ServoReference` gives positions that resist disturbances.
        """
        return ServoCommand(self.q_target, self.v_target, self.tau, gains.kp, gains.kd)

    def __repr__(self) -> str:
        torque = f"largest torque {float(np.abs(self.tau).max(initial=0.0)):.4g} N·m"
        forces = [f"{name} {wrench[2]:.4g} N" for name, wrench in self.wrenches.items()]
        reason = [self.explanation] if self.explanation else []
        return f"Command({', '.join([self.status.value, torque, *forces, *reason])})"
