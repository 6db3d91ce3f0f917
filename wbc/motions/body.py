"""The body as a motion sees it: references to set, and events to wait for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wbc.command import Command
from wbc.gait.planar import point, turn
from wbc.limits.limit import moderate_braking
from wbc.motions.anatomy import Anatomy
from wbc.motions.com_watch import ComWatch
from wbc.motions.footwork import Footwork
from wbc.motions.hands import Hand
from wbc.motions.intent import Intent
from wbc.motions.motion import Script
from wbc.motions.pilot import Pilot
from wbc.motions.posing import Pose
from wbc.motions.reference import Path, SmoothReference
from wbc.robot import Robot
from wbc.state import State
from wbc.walking import BodyOffset, Walker

_FAR = 0.3  # rad
# Share of the posture's weight that is left to joints which are led otherwise.
_LED_ARM, _LED_WAIST = 0.1, 0.03


class Body(Footwork):
    """References of the whole body, each of which goes smoothly where it is told.

    Places are in the *standing frame*: origin on the ground midway between the soles, x
    forward, y left, z up. Motions order; once per tick the performer moves the references on
    and hands them to the walker, which balances.

    Args:
        walker: that balances and steps.

    Attributes:
        robot: the robot.
        anatomy: its arms, head and waist.
        state: as estimated at this tick; None before the first.
        foot_wrenches: sole name -> (6,) measured wrench, sole axes; empty without sensors.
        last_torque: (na,) commanded at the last tick, N·m; None before the first.
        com: (3,) offset of the CoM from where it is when standing, m.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link; `turn_trunk` shares a turn among both.
        posture: (na,) joint positions, rad. The legs follow it only as far as balance lets them.
        hands: the hands by side.
        notes: texts for the report.
        pushes: asked for and not granted yet, (3,) N·s/kg each.
        pilot: what steps in the walker's place; see `take_over`.
    """

    def __init__(self, walker: Walker) -> None:
        super().__init__(walker)
        self.robot: Robot = walker.robot
        self.anatomy = Anatomy.of(walker.robot)
        self.notes: list[str] = []
        self.pushes: list[np.ndarray] = []
        self.pilot: Pilot | None = None
        robot, omega = self.robot, walker.gait.omega
        length = robot.leg_length
        self.com = SmoothReference(
            np.zeros(3), speed=0.3 * omega * length, acceleration=0.1 * omega**2
        )
        self.torso = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.pelvis = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.posture = SmoothReference(
            robot.q_nominal[7:],
            speed=0.6 * np.minimum(robot.v_max, 5.0),
            acceleration=0.5 * moderate_braking(robot),
        )
        self._upper = np.ones(robot.na, dtype=bool)
        self._upper[[index - 6 for leg in robot.legs for index in leg]] = False
        self.hands = {arm.side: Hand(walker, arm) for arm in self.anatomy.arms}
        # What trunk and hands are led to must not fight with the posture: the CoM would pay.
        self._weights = walker.posture.weight.copy()
        self._weights[list(self.anatomy.waist)] *= _LED_WAIST
        walker.posture.weight = self._weights
        self._shares: tuple[float, ...] = ()
        self._offset = BodyOffset()
        self._watch = ComWatch(walker)
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
        self._watch.reset()
        self._offset = BodyOffset()
        self.walker.body = self._offset
        self.walker.velocity = (0.0, 0.0, 0.0)
        self.pilot = None
        self._set_out()

    def _references(self) -> tuple[SmoothReference, ...]:
        return (self.com, self.lean, self.torso, self.pelvis, self.posture, self._foot, self._load)

    # What a motion may ask.

    @property
    def at_home(self) -> bool:
        """Standing, with every reference where it is when standing."""
        return (
            self.standing
            and all(reference.at_home for reference in self._references())
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
            attitude.upright = reference.at_home
            attitude.vector, attitude.rate = reference.value, reference.velocity
            attitude.acceleration = reference.acceleration
        self._place_hands()
        posture = self.walker.posture
        posture.target = self._near(self.posture.value)
        posture.velocity = self.posture.velocity
        posture.acceleration = self.posture.acceleration
        self._place_feet()

    def _near(self, posture: np.ndarray) -> np.ndarray:
        """The posture, but for arms and trunk not so far off that the CoM would pay for it.

        A joint whose torque does not suffice stays behind; what it asks for must stay bounded.
        """
        if self.state is None:
            return posture
        off = posture - self.state.q[7:]
        far = self._upper & (np.abs(off) > _FAR)
        if not far.any():
            return posture
        return np.where(far, self.state.q[7:] + np.clip(off, -_FAR, _FAR), posture)

    def _place_hands(self) -> None:
        if any(hand.engaged for hand in self.hands.values()):
            frame = self.walker.standing_frame
            kin = self.walker.kinematics
            for hand in self.hands.values():
                now = kin.frame(hand.arm.hand).translation
                hand.advance(self.dt, frame.translation, frame.rotation, now)
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

    def observe(self, command: Command) -> None:
        """After the tick."""
        self.last_torque = command.tau
        at_rest = self.pilot is None and (self.standing or self.lifted is not None)
        lean = float(self.lean.acceleration[0])
        self._watch.update(at_rest, self.foot_wrenches, self.com.acceleration, lean)
        self._offset.com_bias = self._watch.offset
        self._feel()
