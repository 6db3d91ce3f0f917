"""The body as a motion sees it: references to set, and events to wait for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.geometry.planar import ground_point, planar_rotation
from wbc.ik.objective import PostureSolution
from wbc.limits.per_joint import default_braking
from wbc.motions.engine.com_bias_observer import ComBiasObserver
from wbc.motions.engine.com_reference import ComReference
from wbc.motions.engine.hands import HandReferences
from wbc.motions.engine.motion import Script
from wbc.motions.engine.motion_reference import MotionReference
from wbc.motions.engine.override import ControllerOverride
from wbc.motions.engine.reference import SmoothReference
from wbc.motions.engine.statics import MOST_TILT
from wbc.state import State
from wbc.walking import ReferenceOffset, Walker

_FAR = 0.3  # rad
_LOWEST = 0.62  # share of the pelvis' height when standing; 0.6 count as a fall


class MotionContext(HandReferences):
    """References of the whole body, each of which goes smoothly where it is told.

    Places are in the *standing frame*: origin on the ground midway between the soles, x
    forward, y left, z up. Motions order; once per tick the player moves the references on
    and hands them to the walker, which balances.

    Args:
        walker: that balances and steps.

    Attributes:
        robot: the robot.
        upper_body: its arms, head and waist.
        state: as estimated at this tick; None before the first.
        foot_wrenches: sole name -> (6,) measured wrench, sole axes; empty without sensors.
        last_torque: (na,) commanded at the last tick, N·m; None before the first.
        com: (3,) offset of the CoM from where it is when standing, m; see `ComReference`.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link; `turn_trunk` shares a turn among both.
        posture: (na,) joint positions, rad. The legs follow it only as far as balance lets them.
        hands: the hands by side.
        notes: texts for the report.
        pushes: asked for and not granted yet, (3,) N·s/kg each.
        override: what steps in the walker's place; see `start_override`.
    """

    def __init__(self, walker: Walker) -> None:
        super().__init__(walker)
        self.notes: list[str] = []
        self.pushes: list[np.ndarray] = []
        self.override: ControllerOverride | None = None
        robot, omega = self.robot, walker.gait.omega
        length = robot.leg_length
        self.com = ComReference(
            speed=0.3 * omega * length,
            acceleration=0.1 * omega**2,
            omega=omega,
            sinking=self._sinking,
            support=self._support,
        )
        self.torso = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.pelvis = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.posture = SmoothReference(
            robot.q_nominal[7:],
            speed=0.6 * np.minimum(robot.v_max, 5.0),
            acceleration=0.5 * default_braking(robot),
        )
        self._upper = np.ones(robot.na, dtype=bool)
        self._upper[[index - 6 for leg in robot.legs for index in leg]] = False
        self._offset = ReferenceOffset()
        self._watch = ComBiasObserver(walker)
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
        self._offset = ReferenceOffset()
        self.walker.reference_offset = self._offset
        self.walker.velocity = (0.0, 0.0, 0.0)
        self.override = None
        self._set_out()

    def _sinking(self) -> float:
        """By how much the pelvis may sink until it nearly counts as a fall, m."""
        if self.state is None:
            return (1.0 - _LOWEST) * float(self.robot.q_nominal[2])
        height = float(self.state.q[2]) - self.walker.feet.left.height
        return height - _LOWEST * float(self.robot.q_nominal[2])

    def _references(self) -> tuple[SmoothReference, ...]:
        return (*self._upper_references(), *self._lower_references())

    def _upper_references(self) -> tuple[SmoothReference, ...]:
        return (self.com, self.torso, self.pelvis, self.posture)

    def _lower_references(self) -> tuple[SmoothReference, ...]:
        return (self.lean, self._foot, self._load)

    # What a motion may ask.

    @property
    def at_home(self) -> bool:
        """Standing, with every reference where it is when standing."""
        lower = all(reference.at_home for reference in self._lower_references())
        return self.standing and lower and self._upper_body_at_home()

    def note(self, text: str) -> None:
        """Say something in the report."""
        self.notes.append(text)

    def request_push(self, impulse: np.ndarray) -> None:
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

        Raises:
            MotionError: the hips' share would tilt the pelvis so far that it counts as a fall.
        """
        turn = np.asarray(turn, dtype=float)
        hips = self.upper_body.hips_share(turn)
        tilt = float(np.hypot(hips[0], hips[1]))
        if tilt > MOST_TILT:
            raise MotionError(
                f"the trunk is to turn so far that the pelvis tilts by {np.degrees(tilt):.0f}°: at "
                f"most {np.degrees(MOST_TILT):.0f}°, more nearly counts as a fall"
            )
        time = self.torso.go(turn, duration)
        self.pelvis.go(hips, time)

    def go_to_posture(self, pose: PostureSolution, duration: float = 1.0) -> None:
        """Go to a whole posture: CoM, trunk and joints together.

        Args:
            pose: as `PostureIK.find` gives it.
            duration: s, at least.
        """
        time = self.posture.go(pose.q[7:], duration)
        self.com.go(pose.com, time)
        self.torso.go(pose.torso, time)
        self.pelvis.go(pose.pelvis, time)

    def home_upper_body(self, duration: float = 1.0) -> None:
        """Order posture, trunk, CoM and hands home, without waiting; the feet go on."""
        for reference in self._upper_references():
            reference.go(reference.home, duration)
        for hand in self.hands.values():
            hand.release(0.5 * duration)

    def home_all(self, duration: float = 1.0) -> None:
        """Order everything home, without waiting: `rest`, and walking ends."""
        self.walker.halt()
        self.home_upper_body(duration)

    def settle_upper_body(self, duration: float = 1.0) -> Script:
        """Bring posture, trunk, CoM and hands home, if they are not; the feet go on."""
        if not self._upper_body_at_home():
            self.home_upper_body(duration)
            yield from self.until(self._upper_body_at_home)

    def _upper_body_at_home(self) -> bool:
        return all(reference.at_home for reference in self._upper_references()) and all(
            not hand.engaged for hand in self.hands.values()
        )

    def go_home(self, duration: float = 1.0) -> Script:
        """Bring everything back to standing, from wherever it is."""
        yield from self.release_override()
        self.home_all(duration)
        yield from self.stand(duration)
        yield from self.until(lambda: self.at_home)

    def release_override(self) -> Script:
        """Have a override come to an end, and hand back."""
        override = self.override
        if override is not None:
            override.abandon()
            yield from self.until(lambda: override.done)
            self.resume_walker()

    def start_override(self, override: ControllerOverride) -> None:
        """From this tick on the override computes the commands, until `resume_walker`."""
        self.override = override

    def resume_walker(self) -> None:
        """The walker balances again, from the body as it is: both soles on the ground.

        It starts anew there. The references take the place and the velocity that the body
        has, and go home from there.
        """
        assert self.state is not None
        self.override = None
        self.walker.reset(self.state)
        for reference in self._references():
            reference.reset()
        self._set_out()
        self.posture.start_from(self.state.q[7:], self.state.v[6:])
        self.posture.go(self.posture.home, 1.5)

    def _set_out(self) -> None:
        """Bring the CoM home, from where it is and as fast as it is."""
        kin, feet = self.walker.kinematics, self.walker.feet
        back = planar_rotation(-self.walker.heading)
        off, speed = (ground_point(kin.p_com) - feet.middle) * back, ground_point(kin.v_com) * back
        self.com.start_from(
            np.array([off.real, off.imag, 0.0]),
            np.array([speed.real, speed.imag, float(kin.v_com[2])]),
        )
        self.com.go(0.0, 1.0)

    # What the player calls.

    def sense(self, estimate: Estimate) -> None:
        """Take the tick's estimate, before the script's tick."""
        self.state, self.foot_wrenches = estimate.state, estimate.foot_wrenches

    def advance(self) -> None:
        """One tick: move the references on and hand them to the walker."""
        self.time += self.dt
        for reference in self._references():
            reference.advance(self.dt)
        offset = self._offset
        offset.com, offset.com_velocity = self.com.value, self.com.velocity
        offset.com_acceleration = self.com.acceleration
        offset.weight_shift = float(self.lean.value[0])
        offset.weight_shift_velocity = float(self.lean.velocity[0])
        offset.weight_shift_acceleration = float(self.lean.acceleration[0])
        for attitude, reference in ((offset.torso, self.torso), (offset.base, self.pelvis)):
            attitude.is_zero = reference.at_home
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

    def reference(self) -> MotionReference:
        """What is promised at this tick."""
        com = None
        if self.override is None and (self.standing or self.lifted is not None):
            com = self.com.value + np.array([0.0, 0.0, self.walker.height])
        targets = tuple(t for hand in self.hands.values() if (t := hand.target) is not None)
        return MotionReference(float(self.lean.value[0]), com, targets)

    def observe(self, command: Command) -> None:
        """After the tick."""
        self.last_torque = command.tau
        at_rest = self.override is None and (self.standing or self.lifted is not None)
        lean = float(self.lean.acceleration[0])
        self._watch.update(at_rest, self.foot_wrenches, self.com.acceleration, lean)
        self._offset.com_bias = self._watch.offset
        self._feel()
