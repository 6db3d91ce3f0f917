"""Protocol of planners: what plans footsteps, centre of mass and DCM."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from wbc.gait.planners.dcm import DcmReference
from wbc.gait.state import GaitCommand, GaitState, PlannedFootstep
from wbc.geometry.planar import Placement


class PlanFailed(UserWarning):
    """A planner found no plan of its own; the text says what it does instead."""


@dataclass(slots=True)
class StepPlan:
    """The present step, as planned at this tick.

    Attributes:
        landing: placement at which the swing foot is to land; None if none swings.
        duration: duration of the present phase, s; None leaves it to the gait parameters. A planner
            that adapts the step timing changes it from tick to tick.
        step_length: length of the present steps, m; long steps lower the centre of mass.
    """

    landing: Placement | None = None
    duration: float | None = None
    step_length: float = 0.0


@runtime_checkable
class Planner(Protocol):
    """Plans footsteps, centre of mass and DCM; give one, or the name of
    one of the library, to `Walker(robot, planner=...)`.

    The gait state machine keeps phases and contacts, the stabilizer feeds the DCM back; in
    between, a planner is asked in this order at every tick:

    1. `next_swing`, while standing and at every touchdown;
    2. `update`, with the phase of now;
    3. `reference`, for the place where the swing foot is planned to land, and once more when
       the stabilizer moves that place.

    While the robot recovers from a push, `reference` is asked for more than one gait and duration
    in a tick: it plans with `state.gait`, `state.duration` and `state.shortened` as they are then.

    What it plans from is the `GaitState`: feet, centre of mass and DCM as estimated, phase and
    time. A planner that takes longer than a tick computes in a thread or process of its own
    and answers from its latest result.
    """

    def reset(self, state: GaitState) -> None:
        """Start anew: the robot stands on both feet."""

    def next_swing(self, state: GaitState, command: GaitCommand) -> str | None:
        """Side of the foot that swings next.

        Asked while standing, when None keeps the robot standing, and in the tick in which the
        swing foot touches down (`state.phase` is still `SWING`), when None makes this
        step the last one: the weight goes to the middle and the robot stands. After a step that
        was shortened to catch a push another one follows in any case.
        """

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """Plan this tick; `state.time` is 0 in the tick in which a phase begins.

        Args:
            state: phase, feet, centre of mass and DCM.
            command: wanted velocity and given footsteps.
            dt: time since the last tick, s.
        """

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """DCM, its velocity and ZMP that the robot should have now.

        Args:
            state: phase, feet, centre of mass and DCM.
            landing: placement at which the swing foot lands; None: as this planner plans.
        """

    def footsteps(self, state: GaitState) -> list[PlannedFootstep]:
        """The next footsteps for display, the landing place of the present swing first."""
