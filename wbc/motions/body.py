"""The body as a motion sees it: references to set, and events to wait for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np

from wbc.balance import ComBias
from wbc.command import Command
from wbc.errors import MotionError
from wbc.gait import LiftedFoot, Phase
from wbc.gait.footsteps import other
from wbc.gait.planar import point, turn
from wbc.motions.anatomy import SIDES, Anatomy, Side
from wbc.motions.hands import Hand
from wbc.motions.intent import Intent
from wbc.motions.motion import Script
from wbc.motions.posing import Pose
from wbc.motions.reference import Path, SmoothReference
from wbc.robot import Robot
from wbc.state import State
from wbc.telemetry import Balance, Footstep, Telemetry
from wbc.walking import BodyOffset, Walker

_SETTLED = 0.005  # m, of the DCM, for
_SETTLE_TIME = 0.25  # s
_STANDS = 0.8  # share of the weight on the soles from which on it stands
_UNLOAD = 0.5  # s in which a foot is relieved of its load, or takes it
_REST = 1.0  # s of standing after steps until the CoM has come to rest
_BIAS_TIME = 0.3  # s within which a bias comes into force, and out of it for steps
# Share of the posture's weight that is left to joints which are led otherwise.
_LED_ARM, _LED_WAIST = 0.1, 0.03
_LOWERING = 0.05  # m/s, of a foot that looks for the ground


class Pilot(Protocol):
    """Steps in the walker's place, for a motion that leaves the ground."""

    def step(self, state: State, foot_wrenches: Mapping[str, np.ndarray] | None = None) -> Command:
        """One tick."""

    def abandon(self) -> None:
        """Return to standing as soon as that is safe."""

    @property
    def done(self) -> bool:
        """It stands, and may be relieved."""

    @property
    def balance(self) -> Balance:
        """How the balance is."""

    @property
    def telemetry(self) -> Telemetry:
        """What it sees and intends, for observers."""

    @property
    def dcm_error(self) -> float:
        """Distance of the DCM from its reference after the last tick, m."""


class Body:
    """References of the whole body, each of which goes smoothly where it is told.

    Places are in the *standing frame*: origin on the ground midway between the soles, x
    forward, y left, z up. Motions order; once per tick the performer moves the references on
    and hands them to the walker, which balances.

    Args:
        walker: that balances and steps.

    Attributes:
        robot: the robot.
        anatomy: its arms, head and waist.
        dt: control period, s.
        time: since the reset, s.
        state: as estimated at this tick; None before the first.
        foot_wrenches: sole name -> (6,) measured wrench, sole axes; empty without sensors.
        last_torque: (na,) commanded at the last tick, N·m; None before the first.
        com: (3,) offset of the CoM from where it is when standing, m.
        lean: (1,) where the weight is: 0 over the right sole, 0.5 in the middle, 1 over the left.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link; `turn_trunk` shares a turn among both.
        posture: (na,) joint positions, rad. The legs follow it only as far as balance lets them.
        hands: the hands by side.
        notes: texts for the report.
        pushes: asked for and not granted yet, (3,) N·s/kg each.
        pilot: what steps in the walker's place; see `take_over`.
    """

    def __init__(self, walker: Walker) -> None:
        self.walker = walker
        self.robot: Robot = walker.robot
        self.anatomy = Anatomy.of(walker.robot)
        self.dt = walker.dt
        self.notes: list[str] = []
        self.pushes: list[np.ndarray] = []
        self.pilot: Pilot | None = None
        robot, omega = self.robot, walker.gait.omega
        length = robot.leg_length
        self.com = SmoothReference(
            np.zeros(3), speed=0.3 * omega * length, acceleration=0.1 * omega**2
        )
        self.lean = SmoothReference(0.5, speed=1.0, acceleration=2.5)
        self.torso = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.pelvis = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.posture = SmoothReference(
            robot.q_nominal[7:], speed=0.6 * np.minimum(robot.v_max, 5.0), acceleration=12.0
        )
        self.hands = {arm.side: Hand(walker, arm) for arm in self.anatomy.arms}
        # What trunk and hands are led to must not fight with the posture: the CoM would pay.
        self._weights = walker.posture.weight.copy()
        self._weights[list(self.anatomy.waist)] *= _LED_WAIST
        walker.posture.weight = self._weights
        self._shares: tuple[float, ...] = ()
        self._foot = SmoothReference(np.zeros(4), speed=0.4, acceleration=2.0)
        self._load = SmoothReference(1.0, speed=4.0, acceleration=40.0)
        self._offset = BodyOffset()
        self._bias = ComBias(omega)
        self._rest = 0.0
        self._calm = 0.0
        self.time = 0.0
        self.state: State | None = None
        self.foot_wrenches: Mapping[str, np.ndarray] = {}
        self.last_torque: np.ndarray | None = None

    def reset(self) -> None:
        """Standing, everything at home. The walker has just been reset."""
        self.time = self._calm = 0.0
        self.notes.clear()
        self.pushes.clear()
        self.posture.home = self.walker.posture.target.copy()
        for reference in self._references():
            reference.reset()
        for hand in self.hands.values():
            hand.reset()
        self._bias = ComBias(self.walker.gait.omega)
        self._rest = _REST
        self._offset = BodyOffset()
        self.walker.body = self._offset
        self.walker.velocity = (0.0, 0.0, 0.0)
        self.pilot = None
        self._set_out()

    def _references(self) -> tuple[SmoothReference, ...]:
        return (self.com, self.lean, self.torso, self.pelvis, self.posture, self._foot, self._load)

    # What a motion may ask.

    @property
    def standing(self) -> bool:
        """Both feet on the ground, and not about to walk."""
        return self.walker.schedule.phase is Phase.STAND

    @property
    def lifted(self) -> Side | None:
        """The foot that is held up."""
        schedule = self.walker.schedule
        if schedule.lifted is None:
            return None
        return "left" if schedule.swing_side == "left" else "right"

    @property
    def settled(self) -> bool:
        """The DCM has stayed within 5 mm of its plan for a quarter of a second."""
        return self._calm >= _SETTLE_TIME

    @property
    def at_home(self) -> bool:
        """Standing, with every reference where it is when standing."""
        return (
            self.standing
            and all(r.arrived and not (r.value != r.home).any() for r in self._references())
            and all(not hand.engaged for hand in self.hands.values())
        )

    def note(self, text: str) -> None:
        """Say something in the report."""
        self.notes.append(text)

    def be_pushed(self, impulse: np.ndarray) -> None:
        """Ask for a push on the torso now; a simulation grants it, a real robot is spared.

        Args:
            impulse: (3,) per kg of the robot, standing frame, N·s/kg.
        """
        self.pushes.append(np.array(impulse, dtype=float))

    # Waiting.

    def wait(self, seconds: float) -> Script:
        """Let time pass."""
        end = self.time + seconds - 0.5 * self.dt
        while self.time < end:
            yield

    def until(self, condition: Callable[[], bool], at_most: float = math.inf) -> Script:
        """Wait for a condition, or until a time is over, s."""
        end = self.time + at_most
        while not condition() and self.time < end:
            yield

    def settle(self, at_most: float = 3.0) -> Script:
        """Wait until the body is `settled`."""
        yield from self.until(lambda: self.settled, at_most)

    def arrive(self, *references: SmoothReference) -> Script:
        """Wait until these references are where they were sent."""
        yield from self.until(lambda: all(r.arrived for r in references))

    # Orders.

    def turn_trunk(self, turn: Sequence[float] | np.ndarray, duration: float = 1.0) -> None:
        """Turn the upper trunk from upright; waist and hips share it.

        Args:
            turn: (3,) rotation vector, standing frame: roll, pitch, yaw for small ones, rad.
            duration: s, at least.
        """
        turn = np.asarray(turn, dtype=float)
        time = self.torso.go(turn, duration)
        self.pelvis.go(self.anatomy.hips_share(turn), time)

    def take(self, pose: Pose, duration: float = 1.0) -> None:
        """Go to a whole posture: CoM, trunk and joints together.

        Args:
            pose: as `Posing.find` gives it.
            duration: s, at least.
        """
        time = self.posture.go(pose.q[7:], duration)
        self.com.go(pose.com, time)
        self.torso.go(pose.torso, time)
        self.pelvis.go(pose.pelvis, time)

    def reach(
        self, side: str, place: Sequence[float] | np.ndarray, duration: float = 1.0, *, counts: bool
    ) -> None:
        """Lead a hand to a place in the standing frame, m; `hands[side].release()` lets go.

        Args:
            side: "left" or "right".
            place: (3,) of the hand's frame, m.
            duration: s, at least.
            counts: whether it is a target to be judged by once it has arrived.

        Raises:
            MotionError: there is no such arm.
        """
        hand = self.hands[self.anatomy.arm(side).side]
        now = self._whereabouts(hand)
        hand.go(np.asarray(place, dtype=float), now, duration, counts=counts)

    def lead(self, side: str, path: Path) -> None:
        """Lead a hand along a path: time, s -> (3,) place in the standing frame, m.

        Raises:
            MotionError: there is no such arm.
        """
        hand = self.hands[self.anatomy.arm(side).side]
        hand.follow(path, self._whereabouts(hand))

    def _whereabouts(self, hand: Hand) -> np.ndarray:
        frame = self.walker.standing_frame
        return np.asarray(frame.actInv(self.walker.kinematics.frame(hand.arm.hand).translation))

    def walk(self, velocity: Sequence[float]) -> None:
        """Walk at a velocity: forward, left (m/s), turn left (rad/s). Zeros stop.

        Raises:
            MotionError: a foot is lifted, or the weight is not in the middle.
        """
        if self.lifted is not None or self.lean.value[0] != 0.5:
            raise MotionError("walk: only from standing on both feet, the weight in the middle")
        self.walker.velocity = (float(velocity[0]), float(velocity[1]), float(velocity[2]))

    def step_in_place(self, steps: int) -> None:
        """Step on the spot, the left foot first."""
        feet = self.walker.feet
        placed = {
            side: Footstep(side, np.array([at.point.real, at.point.imag, at.height]), at.yaw)
            for side in SIDES
            for at in (feet.of(side),)
        }
        self.walker.follow([placed[SIDES[k % 2]] for k in range(steps)])

    # Orders that take several ticks.

    def shift_weight(self, towards: Side | None, duration: float = 1.2) -> Script:
        """Bring the weight over one sole, or between them (None).

        Raises:
            MotionError: a foot is in the air, or the robot walks.
        """
        if not self.standing:
            raise MotionError("shift_weight: only with both feet on the ground")
        self.lean.go({"left": 1.0, "right": 0.0, None: 0.5}[towards], duration)
        yield from self.arrive(self.lean)

    def lift(self, side: Side, height: float, duration: float = 1.0) -> Script:
        """Stand on the other foot, and lift this one by a height, m.

        Raises:
            MotionError: a foot is in the air already, or the robot walks.
        """
        if not self.standing:
            raise MotionError(f"lift: the {side} foot, only with both feet on the ground")
        carries: Side = "left" if other(side) == "left" else "right"
        yield from self.shift_weight(carries)
        yield from self.settle(2.0)
        self.walker.schedule.stand_on(carries)
        self._load.go(0.0, _UNLOAD)
        yield from self.arrive(self._load)
        self._foot.reset()
        self.walker.schedule.lift()
        self._foot.go(np.array([0.0, 0.0, height, 0.0]), duration)
        yield from self.arrive(self._foot)

    def move_foot(
        self, forward: float = 0.0, left: float = 0.0, up: float = 0.05, duration: float = 1.0
    ) -> Script:
        """Move the lifted foot to a place relative to where it left the ground, m.

        Raises:
            MotionError: no foot is in the air.
        """
        if self.lifted is None:
            raise MotionError("move_foot: no foot is lifted; lift one first")
        self._foot.go(np.array([forward, left, up, 0.0]), duration)
        yield from self.arrive(self._foot)

    def put_down(self, duration: float = 1.0) -> Script:
        """Lower the lifted foot until it feels the ground, and stand on both feet again."""
        schedule = self.walker.schedule
        foot = schedule.lifted
        if foot is None:
            return
        above = self._foot.value * np.array([1.0, 1.0, 0.0, 1.0])
        above[2] = 0.01
        if self._foot.value[2] > 0.015:
            self._foot.go(above, duration)
            yield from self.arrive(self._foot)
        foot.landing = True
        start = self._foot.value.copy()
        down = np.array([0.0, 0.0, -_LOWERING, 0.0])
        self._foot.follow(lambda t: start + t * down, blend=0.3)
        yield from self.until(lambda: self.standing)
        self._foot.reset()
        self._load.go(1.0, _UNLOAD)
        yield from self.arrive(self._load)
        yield from self.shift_weight(None)

    def relax(self, duration: float = 1.0) -> None:
        """Order everything home, without waiting: posture, trunk, CoM, hands; walking ends."""
        self.walker.halt()
        for reference in (self.com, self.torso, self.pelvis, self.posture):
            reference.go(reference.home, duration)
        for hand in self.hands.values():
            hand.release(0.5 * duration)

    def go_home(self, duration: float = 1.0) -> Script:
        """Bring everything back to standing, from wherever it is."""
        yield from self.relieve()
        self.relax(duration)
        yield from self.stand(duration)
        yield from self.until(lambda: self.at_home)

    def stand(self, duration: float = 1.0) -> Script:
        """Bring both feet to the ground, the weight between them."""
        yield from self.put_down()
        yield from self.until(lambda: self.standing)
        if self._load.value[0] < 1.0 or self.lean.value[0] != 0.5:
            self._load.go(1.0, _UNLOAD)
            self.lean.go(0.5, duration)
            yield from self.arrive(self._load, self.lean)

    def relieve(self) -> Script:
        """Have a pilot come to an end, and hand back."""
        pilot = self.pilot
        if pilot is not None:
            pilot.abandon()
            yield from self.until(lambda: pilot.done)
            self.hand_back()

    def take_over(self, pilot: Pilot) -> None:
        """From this tick on the pilot computes the commands, until `hand_back`."""
        self.pilot = pilot

    def hand_back(self) -> None:
        """The walker balances again, from the body as it is: both soles on the ground.

        It starts anew there. The references take the place and the velocity that the body
        has, and go home from there.
        """
        assert self.state is not None
        self.pilot = None
        self.walker.reset(self.state)
        for reference in self._references():
            reference.reset()
        self._set_out()
        self.posture.start_from(self.state.q[7:], self.state.v[6:])
        self.posture.go(self.posture.home, 1.5)

    def _set_out(self) -> None:
        """Bring the CoM home, from where it is and as fast as it is."""
        kin, feet = self.walker.kinematics, self.walker.feet
        back = turn(-self.walker.heading)
        off, speed = (point(kin.p_com) - feet.middle) * back, point(kin.v_com) * back
        self.com.start_from(
            np.array([off.real, off.imag, 0.0]),
            np.array([speed.real, speed.imag, float(kin.v_com[2])]),
        )
        self.com.go(0.0, 1.0)

    # What the performer calls.

    def sense(self, state: State, foot_wrenches: Mapping[str, np.ndarray] | None) -> None:
        """Before the script's tick."""
        self.state, self.foot_wrenches = state, foot_wrenches or {}

    def advance(self) -> None:
        """One tick: move the references on and hand them to the walker."""
        self.time += self.dt
        for reference in self._references():
            reference.advance(self.dt)
        offset = self._offset
        offset.com, offset.com_velocity = self.com.value, self.com.velocity
        offset.com_acceleration = self.com.acceleration
        offset.lean = float(self.lean.value[0])
        offset.lean_rate = float(self.lean.velocity[0])
        offset.lean_acceleration = float(self.lean.acceleration[0])
        for attitude, reference in ((offset.torso, self.torso), (offset.base, self.pelvis)):
            attitude.vector, attitude.rate = reference.value, reference.velocity
            attitude.acceleration = reference.acceleration
        self._place_hands()
        posture = self.walker.posture
        posture.target = self.posture.value
        posture.velocity = self.posture.velocity
        posture.acceleration = self.posture.acceleration
        schedule = self.walker.schedule
        load = float(self._load.value[0])
        schedule.swing_load = load if load < 1.0 else math.inf
        foot = schedule.lifted
        if foot is not None:
            self._move(foot)

    def _move(self, foot: LiftedFoot) -> None:
        foot.offset, foot.rate = self._foot.value, self._foot.velocity
        foot.push = self._foot.acceleration

    def _place_hands(self) -> None:
        if any(hand.engaged for hand in self.hands.values()):
            frame = self.walker.standing_frame
            for hand in self.hands.values():
                hand.advance(self.dt, frame.translation, frame.rotation)
        shares = tuple(hand.share for hand in self.hands.values())
        if shares != self._shares:
            self._shares = shares
            weights = self._weights.copy()
            for hand in self.hands.values():
                weights[list(hand.arm.joints)] *= 1.0 - (1.0 - _LED_ARM) * hand.share
            self.walker.posture.weight = weights

    def intent(self) -> Intent:
        """What is promised at this tick."""
        com = None
        if self.pilot is None and (self.standing or self.lifted is not None):
            com = self.com.value + np.array([0.0, 0.0, self.walker.height])
        targets = tuple(t for hand in self.hands.values() if (t := hand.target) is not None)
        return Intent(float(self.lean.value[0]), com, targets)

    def _watch_com(self) -> None:
        """Compare the estimated CoM with the measured centre of pressure."""
        feet, com = self.walker.feet, point(self.walker.kinematics.p_com)
        load, moment = 0.0, 0j
        for sole in self.robot.soles:
            wrench = self.foot_wrenches.get(sole.name)
            if wrench is not None and wrench[2] > 0.0:
                at = complex(-float(wrench[4]), float(wrench[3]))  # times the force
                placed = feet.of(sole.side)
                moment += float(wrench[2]) * placed.point + at * turn(placed.yaw)
                load += float(wrench[2])
        if load < _STANDS * self.robot.weight:
            return
        back = turn(-self.walker.heading)
        wanted = self.com.acceleration
        across = (feet.left.point - feet.right.point) * back
        acceleration = complex(float(wanted[0]), float(wanted[1]))
        acceleration += float(self.lean.acceleration[0]) * across
        self._bias.update(self.dt, com * back, acceleration, moment / load * back)

    def observe(self, command: Command) -> None:
        """After the tick."""
        self.last_torque = command.tau
        at_rest = self.pilot is None and (self.standing or self.lifted is not None)
        self._rest = self._rest + self.dt if at_rest else 0.0
        wanted = 0j
        if self._rest >= _REST:
            self._watch_com()
            wanted = self._bias.value
        self._offset.com_bias += (wanted - self._offset.com_bias) * (self.dt / _BIAS_TIME)
        self._calm = self._calm + self.dt if self.walker.dcm_error < _SETTLED else 0.0
