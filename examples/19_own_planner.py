"""Write your own planner, which gives ZMP, DCM and the swing foot to the walker.

This one shifts the weight from side to side and never steps.
"""

import cmath
import math

import wbc
from wbc.gait import DcmReference, GaitCommand, GaitState, Placement, PlannedFootstep, StepPlan
from wbc.sim import Mujoco

AMPLITUDE, PERIOD = 0.03, 2.5  # m, s


class SidewaysSway:
    """A lateral sway of the linear inverted pendulum with a sinusoidal CoM."""

    def reset(self, state: GaitState) -> None:
        """Start midway between the feet."""
        self.time = 0.0
        self.middle = state.feet.middle

    def next_swing(self, state: GaitState, command: GaitCommand) -> str | None:
        """Keep both feet on the ground."""
        return None

    def update(self, state: GaitState, command: GaitCommand, dt: float) -> StepPlan:
        """Advance the time; no foot swings, so there is no footstep."""
        self.time += dt
        return StepPlan()

    def reference(self, state: GaitState, landing: Placement | None = None) -> DcmReference:
        """DCM ξ = c + ċ/ω and ZMP p = c − c̈/ω² of a CoM c that sways sideways."""
        omega, rate = state.gait.omega, 2.0 * math.pi / PERIOD
        fade = min(self.time / PERIOD, 1.0)
        com = fade * AMPLITUDE * cmath.exp(1j * rate * self.time)
        velocity, acceleration = 1j * rate * com, -(rate**2) * com

        def sideways(z: complex) -> complex:
            return complex(0.0, z.imag)

        dcm = self.middle + sideways(com + velocity / omega)
        return DcmReference(
            dcm,
            sideways(velocity + acceleration / omega),
            self.middle + sideways(com - acceleration / omega**2),
        )

    def footsteps(self, state: GaitState) -> list[PlannedFootstep]:
        """Return no footsteps."""
        return []


robot = wbc.load("simple_humanoid")
walker = wbc.Walker(robot, planner=SidewaysSway())
with Mujoco(robot) as plant:
    print(wbc.run(walker, plant, duration=8.0))
