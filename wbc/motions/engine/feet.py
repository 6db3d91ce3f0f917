"""FootReferences of motions: where the weight is, a foot in the air, steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wbc.errors import MotionError
from wbc.gait import Phase
from wbc.gait.footsteps import other_side
from wbc.geometry.planar import planar_rotation
from wbc.geometry.polygon import convex_hull, sole_corners
from wbc.motions.engine.clock import ScriptClock
from wbc.motions.engine.com_reference import ComReference
from wbc.motions.engine.motion import Script
from wbc.motions.engine.reference import SmoothReference
from wbc.robot.upper_body import SIDES, Side
from wbc.telemetry import Footstep
from wbc.walking import Walker

_SETTLED = 0.005  # m, of the DCM, for
_SETTLE_TIME = 0.25  # s
_PATIENCE = 4.0  # s
_BRAKING = 0.3  # share of the sole's half width in which a shift of the weight is braked
_UNLOAD = 0.5  # s in which a foot is relieved of its load, or takes it
_AWAY = 0.01  # m, rad: from there on a foot is brought back before it is put down
_CLEAR = 0.03  # m over the ground, on its way
_LOWERING = 0.05  # m/s, of a foot that looks for the ground


class FootReferences(ScriptClock):
    """Shifts the weight, lifts a foot and puts it down where it feels the ground, steps.

    Args:
        walker: that balances and steps.

    Attributes:
        walker: that balances and steps.
        lean: (1,) where the weight is: 0 over the right sole, 0.5 in the middle, 1 over the left.
        com: (3,) offset of the CoM, which `MotionContext` leads.
    """

    com: ComReference

    def __init__(self, walker: Walker) -> None:
        super().__init__(walker.dt)
        self.walker = walker
        self.lean = SmoothReference(0.5, speed=1.0, acceleration=2.5)
        self._foot = SmoothReference(np.zeros(4), speed=0.4, acceleration=2.0)
        self._load = SmoothReference(1.0, speed=4.0, acceleration=40.0)
        self._calm = 0.0

    @property
    def standing(self) -> bool:
        """Both feet on the ground, and not about to walk."""
        return self.walker.state_machine.phase is Phase.STAND

    @property
    def lifted(self) -> Side | None:
        """The foot that is held up."""
        state_machine = self.walker.state_machine
        if state_machine.lifted is None:
            return None
        return "left" if state_machine.swing_side == "left" else "right"

    @property
    def may_walk(self) -> bool:
        """No foot is lifted, and the weight is in the middle; it may be walking."""
        return self.lifted is None and self.lean.value[0] == 0.5

    @property
    def settled(self) -> bool:
        """The DCM has stayed within 5 mm of its plan for a quarter of a second."""
        return self._calm >= _SETTLE_TIME

    def _support(self) -> list[complex]:
        """Corners of what carries, about where the CoM is at rest, standing axes; none on its way.

        Where the CoM is at rest is between the soles' centres by the share of `lean`.
        """
        lifted = self.lifted
        if not (self.standing or lifted):
            return []
        feet, back = self.walker.feet, planar_rotation(-self.walker.heading)
        right, left = feet.right.point, feet.left.point
        middle = right + float(self.lean.value[0]) * (left - right)
        points = [
            (corner - middle) * back
            for sole in self.walker.robot.soles
            if sole.side != lifted
            for corner in sole_corners(feet.of(sole.side), sole.half_length, sole.half_width)
        ]
        return convex_hull(points)

    def walk(self, velocity: Sequence[float]) -> None:
        """Walk at a velocity: forward, left (m/s), turn left (rad/s). Zeros stop.

        Raises:
            MotionError: a foot is lifted, the weight is not in the middle, or the CoM is led.
        """
        self._may_step("walk")
        self.walker.velocity = (float(velocity[0]), float(velocity[1]), float(velocity[2]))

    def step_in_place(self, steps: int) -> None:
        """Step on the spot, the left foot first.

        Raises:
            MotionError: see `walk`.
        """
        self._may_step("step_in_place")
        feet = self.walker.feet
        placed = {
            side: Footstep(side, np.array([at.point.real, at.point.imag, at.height]), at.yaw)
            for side in SIDES
            for at in (feet.of(side),)
        }
        self.walker.follow([placed[SIDES[k % 2]] for k in range(steps)])

    def _may_step(self, what: str) -> None:
        if not self.may_walk:
            raise MotionError(f"{what}: only from standing on both feet, the weight in the middle")
        self._must_not_lead_com(what)

    def _must_not_lead_com(self, what: str) -> None:
        if self.com.led:
            raise MotionError(f"{what}: only with the centre of mass at home; bring it there first")

    def touchdown(self, at_most: float = math.inf) -> Script:
        """Wait until the next swinging foot has landed, or a time is over, s."""
        steps = self.walker.steps
        yield from self.until(lambda: self.walker.steps > steps, at_most)

    def settle(self, at_most: float = 3.0) -> Script:
        """Wait until the body is `settled`."""
        yield from self.until(lambda: self.settled, at_most)

    def shift_weight(self, towards: Side | None, duration: float = 1.2) -> Script:
        """Bring the weight over one sole, or between them (None).

        Args:
            towards: "left", "right" or None.
            duration: s; longer when the sole is too narrow to brake the CoM on it.

        Raises:
            MotionError: a foot is in the air, or the robot walks.
        """
        if not self.standing:
            raise MotionError("shift_weight: only with both feet on the ground")
        lean = {"left": 1.0, "right": 0.0, None: 0.5}[towards]
        if towards is not None:
            duration = max(duration, self._braking_time(lean))
        self.lean.go(lean, duration)
        yield from self.arrive(self.lean)

    def _braking_time(self, lean: float) -> float:
        """Least duration of a shift onto one sole, s.

        Where a minimum-jerk way of length D brakes most, 6 % before its end, the ZMP is ahead of
        the CoM by 5.77 D / (ω T)²: it has to stay within some of the sole's half width.
        """
        feet, omega = self.walker.feet, self.walker.gait.omega
        way = abs(lean - float(self.lean.value[0])) * abs(feet.left.point - feet.right.point)
        room = 0.06 * way + _BRAKING * min(s.half_width for s in self.walker.robot.soles)
        return math.sqrt(5.77 * way / room) / omega

    def lift(self, side: Side, height: float, duration: float = 1.0) -> Script:
        """Stand on the other foot, and lift this one by a height, m.

        Raises:
            MotionError: a foot is in the air already, the robot walks, the CoM is led, or it does
                not come to rest on the other foot.
        """
        self._must_not_lead_com("lift")
        if not self.standing:
            raise MotionError(f"lift: the {side} foot, only with both feet on the ground")
        carries: Side = "left" if other_side(side) == "left" else "right"
        yield from self.shift_weight(carries)
        yield from self.settle(_PATIENCE)
        if not self.settled:
            raise MotionError(
                f"the {side} foot stays: {self.walker.robot.name} did not come to rest on the "
                f"{carries} one (DCM {1e3 * self.walker.dcm_error:.0f} mm off)"
            )
        self.walker.state_machine.stand_on(carries)
        self._load.go(0.0, _UNLOAD)
        yield from self.arrive(self._load)
        self._foot.reset()
        self.walker.state_machine.lift()
        self._foot.go(np.array([0.0, 0.0, height, 0.0]), duration)
        yield from self.arrive(self._foot)

    def move_foot(
        self, forward: float = 0.0, left: float = 0.0, up: float = 0.05, duration: float = 1.0
    ) -> Script:
        """Move the lifted foot to a place relative to where it left the ground, m.

        Raises:
            MotionError: no foot is in the air, or the place is below the ground.
        """
        if self.lifted is None:
            raise MotionError("move_foot: no foot is lifted; lift one first")
        if up < 0.0:
            raise MotionError(f"move_foot: up = {up:g} m is below the ground; see put_down")
        self._foot.go(np.array([forward, left, up, 0.0]), duration)
        yield from self.arrive(self._foot)

    def put_down(self, duration: float = 1.0) -> Script:
        """Lower the lifted foot until it feels the ground, and stand on both feet again."""
        state_machine = self.walker.state_machine
        foot = state_machine.lifted
        if foot is None:
            return
        above = self._foot.value * np.array([1.0, 1.0, 0.0, 1.0])
        above[2] = 0.01
        if self._foot.value[2] > 0.015:
            self._foot.go(above, duration)
            yield from self.arrive(self._foot)
        foot.expects_contact = True
        start = self._foot.value.copy()
        down = np.array([0.0, 0.0, -_LOWERING, 0.0])
        self._foot.follow(lambda t: start + t * down, blend=0.3)
        yield from self.until(lambda: self.standing)
        self._foot.reset()
        self._load.go(1.0, _UNLOAD)
        yield from self.arrive(self._load)
        yield from self.shift_weight(None)

    def stand(self, duration: float = 1.0) -> Script:
        """Bring both feet to the ground where they stood, the weight between them."""
        away = float(np.abs(self._foot.value[[0, 1, 3]]).max())
        if self.lifted is not None and away > _AWAY:
            yield from self.move_foot(up=max(float(self._foot.value[2]), _CLEAR))
        yield from self.put_down()
        yield from self.until(lambda: self.standing)
        if self._load.value[0] < 1.0 or self.lean.value[0] != 0.5:
            self._load.go(1.0, _UNLOAD)
            self.lean.go(0.5, duration)
            yield from self.arrive(self._load, self.lean)

    def _place_feet(self) -> None:
        """Hand the references of load and lifted foot to the gait."""
        state_machine = self.walker.state_machine
        load = float(self._load.value[0])
        state_machine.swing_load = load if load < 1.0 else math.inf
        foot = state_machine.lifted
        if foot is not None:
            foot.offset, foot.offset_velocity = self._foot.value, self._foot.velocity
            foot.offset_acceleration = self._foot.acceleration

    def _feel(self) -> None:
        """After a tick: how long the DCM has been where it should be."""
        self._calm = self._calm + self.dt if self.walker.dcm_error < _SETTLED else 0.0
