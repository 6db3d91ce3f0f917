"""References of the feet: shifting the weight, lifting and placing a foot, steps."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wbc.errors import MotionError
from wbc.gait.footsteps import other_side
from wbc.motions.engine.clock import Script, ScriptClock
from wbc.motions.engine.com_reference import ComReference
from wbc.motions.engine.reference import SmoothReference
from wbc.motions.engine.stance import Stance
from wbc.robot.upper_body import SIDES, Side
from wbc.telemetry import Footstep
from wbc.walking import Walker

_SETTLED = 0.2  # share of the soles' half width, DCM error below which the robot is settled
_LEAST_SETTLED = 0.005  # m, the same of narrow soles
_SETTLE_TIME = 0.25  # s for which the error has to stay below
_SETTLE_TIMEOUT = 4.0  # s
_BRAKING = 0.3  # share of the sole's half width that brakes a shift of the weight
_UNLOAD = 0.5  # s in which a foot is unloaded, or loaded
_AWAY = 0.01  # m, rad: a foot that is farther off is brought back before it is put down
_CLEARANCE = 0.03  # m over the ground on the way back
_LOWERING = 0.05  # m/s of a foot that searches for the ground


class FootReferences:
    """Shifts the weight, lifts a foot, moves it, puts it down where it feels the ground; steps.

    Args:
        walker: the walker, which balances and steps.
        clock: clock of the scripts.
        stance: supporting feet.
        com: offset of the CoM: while it is active, feet must stay on the ground.
    """

    def __init__(
        self, walker: Walker, clock: ScriptClock, stance: Stance, com: ComReference
    ) -> None:
        self._walker, self._clock, self._stance, self._com = walker, clock, stance, com
        # Position of the lifted foot from where it left the ground, m, and its yaw, rad.
        self._foot = SmoothReference(np.zeros(4), speed=0.4, acceleration=2.0)
        # Share of the weight that the foot which is to be lifted may carry.
        self._load = SmoothReference(1.0, speed=4.0, acceleration=40.0)
        half_width = min(sole.half_width for sole in walker.robot.soles)
        self._settled_error = max(_SETTLED * half_width, _LEAST_SETTLED)  # m
        self._settled_for = 0.0

    def reset(self) -> None:
        """Put both feet on the ground, with the weight in the middle, at once."""
        for reference in self._references():
            reference.reset()
        self._settled_for = 0.0

    @property
    def at_home(self) -> bool:
        """Whether both feet are on the ground and share the weight equally."""
        return all(reference.at_home for reference in self._references())

    @property
    def settled(self) -> bool:
        """Whether the DCM has stayed within 5 mm of its plan for a quarter of a second."""
        return self._settled_for >= _SETTLE_TIME

    def _references(self) -> tuple[SmoothReference, ...]:
        return (self._stance.weight_shift, self._foot, self._load)

    # Steps.

    def walk(self, velocity: Sequence[float]) -> None:
        """Walk at a velocity: forward, left (m/s) and turn left (rad/s). Zeros stop.

        Raises:
            MotionError: a foot is lifted, the weight is not in the middle, or the CoM is away
                from home.
        """
        self._check_may_step("walk")
        self._walker.velocity = (float(velocity[0]), float(velocity[1]), float(velocity[2]))

    def step_in_place(self, steps: int) -> None:
        """Step on the spot, with the left foot first.

        Raises:
            MotionError: see `walk`.
        """
        self._check_may_step("step_in_place")
        feet = self._walker.feet
        placed = {
            side: Footstep(side, np.array([at.point.real, at.point.imag, at.height]), at.yaw)
            for side in SIDES
            for at in (feet.of(side),)
        }
        self._walker.follow([placed[SIDES[k % 2]] for k in range(steps)])

    def until_touchdown(self, timeout: float = math.inf) -> Script:
        """Wait until the next swing foot has landed, or until a time is over, s."""
        steps = self._walker.steps
        yield from self._clock.until(lambda: self._walker.steps > steps, timeout)

    def until_settled(self, timeout: float = 3.0) -> Script:
        """Wait until the robot is `settled`, or until a time is over, s."""
        yield from self._clock.until(lambda: self.settled, timeout)

    def _check_may_step(self, what: str) -> None:
        if not self._stance.may_walk:
            raise MotionError(f"{what}: only from standing on both feet, the weight in the middle")
        self._check_com_at_home(what)

    def _check_com_at_home(self, what: str) -> None:
        if self._com.active:
            raise MotionError(f"{what}: only with the centre of mass at home; bring it there first")

    # Weight and lifted foot.

    def shift_weight(self, towards: Side | None, duration: float = 1.2) -> Script:
        """Bring the weight over one sole, or between them.

        Args:
            towards: "left", "right", or None for the middle.
            duration: s; longer when the sole is too narrow to brake the CoM on it.

        Raises:
            MotionError: a foot is in the air, or the robot walks.
        """
        if not self._stance.standing:
            raise MotionError("shift_weight: only with both feet on the ground")
        share = {"left": 1.0, "right": 0.0, None: 0.5}[towards]
        if towards is not None:
            duration = max(duration, self._braking_time(share))
        self._stance.weight_shift.move_to(share, duration)
        yield from self._clock.until_arrived(self._stance.weight_shift)

    def _braking_time(self, share: float) -> float:
        """Return the least duration of a shift of the weight onto one sole, s.

        Where a minimum-jerk motion of length D brakes most, 6 % before its end, the ZMP is ahead
        of the CoM by 5.77 D / (ω T)²: it has to stay within a part of the sole's half width.
        """
        feet, omega = self._walker.feet, self._walker.gait.omega
        now = float(self._stance.weight_shift.value[0])
        distance = abs(share - now) * abs(feet.left.point - feet.right.point)
        half_width = min(sole.half_width for sole in self._walker.robot.soles)
        return math.sqrt(5.77 * distance / (0.06 * distance + _BRAKING * half_width)) / omega

    def lift(self, side: Side, height: float, duration: float = 1.0) -> Script:
        """Stand on the other foot, and lift this one.

        Args:
            side: side of the foot to lift.
            height: height of the sole over the place where it stood, m.
            duration: shortest duration of the lifting, s.

        Raises:
            MotionError: a foot is in the air already, the robot walks, the CoM is away from
                home, or the robot does not come to rest on the other foot.
        """
        self._check_com_at_home("lift")
        if not self._stance.standing:
            raise MotionError(f"lift: the {side} foot, only with both feet on the ground")
        support: Side = "left" if other_side(side) == "left" else "right"
        yield from self.shift_weight(support)
        yield from self.until_settled(_SETTLE_TIMEOUT)
        if not self.settled:
            raise MotionError(
                f"the {side} foot stays on the ground: {self._walker.robot.name} did not come to "
                f"rest on the {support} one (DCM {1e3 * self._walker.dcm_error:.0f} mm off)"
            )
        self._walker.state_machine.stand_on(support)
        self._load.move_to(0.0, _UNLOAD)
        yield from self._clock.until_arrived(self._load)
        self._foot.reset()
        self._walker.state_machine.lift()
        self._foot.move_to(np.array([0.0, 0.0, height, 0.0]), duration)
        yield from self._clock.until_arrived(self._foot)

    def move_foot(
        self, forward: float = 0.0, left: float = 0.0, up: float = 0.05, duration: float = 1.0
    ) -> Script:
        """Move the lifted foot to a position relative to where it left the ground, m.

        Raises:
            MotionError: no foot is in the air, or the position is below the ground.
        """
        if self._stance.lifted is None:
            raise MotionError("move_foot: no foot is lifted; lift one first")
        if up < 0.0:
            raise MotionError(f"move_foot: up = {up:g} m is below the ground; see put_down")
        self._foot.move_to(np.array([forward, left, up, 0.0]), duration)
        yield from self._clock.until_arrived(self._foot)

    def put_down(self, duration: float = 1.0) -> Script:
        """Lower the lifted foot until it feels the ground, and stand on both feet again."""
        foot = self._walker.gait_state.lifted
        if foot is None:
            return
        above = self._foot.value * np.array([1.0, 1.0, 0.0, 1.0])
        above[2] = 0.01
        if self._foot.value[2] > 0.015:
            self._foot.move_to(above, duration)
            yield from self._clock.until_arrived(self._foot)
        foot.expects_contact = True
        start = self._foot.value.copy()
        down = np.array([0.0, 0.0, -_LOWERING, 0.0])
        self._foot.follow(lambda t: start + t * down, blend=0.3)
        yield from self._clock.until(lambda: self._stance.standing)
        self._foot.reset()
        self._load.move_to(1.0, _UNLOAD)
        yield from self._clock.until_arrived(self._load)
        yield from self.shift_weight(None)

    def stand(self, duration: float = 1.0) -> Script:
        """Bring both feet to the ground where they stood, and the weight between them."""
        away = float(np.abs(self._foot.value[[0, 1, 3]]).max())
        if self._stance.lifted is not None and away > _AWAY:
            yield from self.move_foot(up=max(float(self._foot.value[2]), _CLEARANCE))
        yield from self.put_down()
        yield from self._clock.until(lambda: self._stance.standing)
        weight_shift = self._stance.weight_shift
        if self._load.value[0] < 1.0 or weight_shift.value[0] != 0.5:
            self._load.move_to(1.0, _UNLOAD)
            weight_shift.move_to(0.5, duration)
            yield from self._clock.until_arrived(self._load, weight_shift)

    # The tick.

    def advance(self, dt: float) -> None:
        """Advance the references by a tick, s."""
        for reference in self._references():
            reference.advance(dt)

    def apply(self) -> None:
        """Hand the references of load and lifted foot to the gait."""
        state = self._walker.gait_state
        load = float(self._load.value[0])
        state.other_foot_load = load if load < 1.0 else math.inf
        foot = state.lifted
        if foot is not None:
            foot.offset, foot.offset_velocity = self._foot.value, self._foot.velocity
            foot.offset_acceleration = self._foot.acceleration

    def observe(self) -> None:
        """After a tick: count for how long the DCM has been close to its plan."""
        settled = self._walker.dcm_error < self._settled_error
        self._settled_for = self._settled_for + self._clock.dt if settled else 0.0
