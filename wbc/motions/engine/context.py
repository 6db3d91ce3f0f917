"""What a motion's script is given: references of the whole body to set, and events to wait for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.geometry.planar import ground_point, planar_rotation
from wbc.ik.objective import PostureSolution
from wbc.ik.posture_checks import MAX_PELVIS_TILT
from wbc.limits.per_joint import default_braking
from wbc.motions.engine.clock import Script, ScriptClock
from wbc.motions.engine.com_reference import ComReference
from wbc.motions.engine.feet import FootReferences
from wbc.motions.engine.hands import HandReferences
from wbc.motions.engine.motion_reference import MotionReference
from wbc.motions.engine.override import ControllerOverride
from wbc.motions.engine.reference import SmoothReference
from wbc.motions.engine.stance import Stance
from wbc.robot.upper_body import UpperBody
from wbc.state import State
from wbc.walking import ReferenceOffset, Walker

_MAX_POSTURE_ERROR = 0.3  # rad, of arms and trunk
_HANDOVER_TIME = 1.5  # s, for the posture after an override


class MotionContext:
    """References of the whole body, each of which moves smoothly to its targets.

    Positions are in the *standing frame*: origin on the ground midway between the soles, x
    forward, y left, z up. Motions set targets; once per tick the player advances the references
    and hands them to the walker, which balances.

    Args:
        walker: the walker, which balances and steps.

    Attributes:
        walker: the walker.
        robot: its robot.
        upper_body: arms, head and waist of the robot.
        clock: counts time; `wait`, `until` and `until_arrived` let ticks pass.
        stance: which feet carry, and where the weight is.
        feet: shifts the weight, lifts and places feet, steps.
        hands: leads the hands.
        com: (3,) offset of the CoM from its place when standing, m; see `ComReference`.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link; `turn_trunk` shares a rotation between both.
        posture: (na,) joint positions, rad. The legs follow only as far as balance lets them.
        notes: texts for the report.
        note_time: `clock.time` of the latest note, s.
        pushes: requested and not yet granted, (3,) N·s/kg each.
        override: the controller that steps instead of the walker, or None.
        state: estimate of this tick; None before the first.
        last_torque: (na,) torques of the last tick, N·m; None before the first.
    """

    def __init__(self, walker: Walker) -> None:
        self.walker = walker
        self.robot = robot = walker.robot
        self.upper_body = UpperBody.of(robot)
        omega = walker.gait.omega
        self.clock = ScriptClock(walker.dt)
        self.stance = Stance(walker)
        self.com = ComReference(
            speed=0.3 * omega * robot.leg_length,
            acceleration=0.1 * omega**2,
            omega=omega,
            descent=self._descent,
            support=self.stance.polygon,
        )
        self.feet = FootReferences(walker, self.clock, self.stance, self.com)
        self.hands = HandReferences(walker, self.upper_body)
        self.torso = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.pelvis = SmoothReference(np.zeros(3), speed=1.2, acceleration=4.0)
        self.posture = SmoothReference(
            robot.q_nominal[7:],
            speed=0.6 * np.minimum(robot.v_max, 5.0),
            acceleration=0.5 * default_braking(robot),
        )
        self._not_legs = np.ones(robot.na, dtype=bool)
        self._not_legs[[index - 6 for leg in robot.legs for index in leg]] = False
        self._offset = ReferenceOffset()
        self._estimate: Estimate | None = None
        self.notes: list[str] = []
        self.pushes: list[np.ndarray] = []
        self.override: ControllerOverride | None = None
        self.last_torque: np.ndarray | None = None

    def __repr__(self) -> str:
        away = [name for name, r in self._named_references() if not r.at_home]
        return (
            f"MotionContext({self.robot.name} at {self.time:.2f} s, "
            f"{'away from home: ' + ', '.join(away) if away else 'at home'})"
        )

    def reset(self) -> None:
        """Stand with every reference at home. The walker has just been reset."""
        self.clock.time = self.note_time = 0.0
        self.notes.clear()
        self.pushes.clear()
        self.posture.home = self.walker.posture.target.copy()
        for reference in self._upper_body_references():
            reference.reset()
        self.feet.reset()
        self.hands.reset()
        self._offset = ReferenceOffset()
        self.walker.reference_offset = self._offset
        self.walker.velocity = (0.0, 0.0, 0.0)
        self.override = None
        self._bring_com_home()

    def _named_references(self) -> tuple[tuple[str, SmoothReference], ...]:
        return (
            ("com", self.com),
            ("torso", self.torso),
            ("pelvis", self.pelvis),
            ("posture", self.posture),
            ("weight", self.stance.weight_shift),
        )

    def _upper_body_references(self) -> tuple[SmoothReference, ...]:
        return (self.com, self.torso, self.pelvis, self.posture)

    def _descent(self) -> float:
        state = self.state
        return self.stance.descent(self.robot.q_nominal if state is None else state.q)

    # State.

    @property
    def dt(self) -> float:
        """Control period, s."""
        return self.clock.dt

    @property
    def time(self) -> float:
        """Time since the reset, s."""
        return self.clock.time

    @property
    def state(self) -> State | None:
        """Estimated state of this tick; None before the first."""
        return None if self._estimate is None else self._estimate.state

    @property
    def standing(self) -> bool:
        """Whether both feet are on the ground and the robot is not about to walk."""
        return self.stance.standing

    @property
    def at_home(self) -> bool:
        """Whether the robot stands, with every reference at home."""
        return self.standing and self.feet.at_home and self._upper_body_at_home()

    def _upper_body_at_home(self) -> bool:
        references = self._upper_body_references()
        return all(r.at_home for r in references) and not self.hands.engaged

    # Waiting.

    def wait(self, seconds: float) -> Script:
        """Let a time pass, s."""
        return self.clock.wait(seconds)

    def until(self, condition: Callable[[], bool], timeout: float = math.inf) -> Script:
        """Wait until a condition holds, or until a time is over, s."""
        return self.clock.until(condition, timeout)

    def until_arrived(self, *references: SmoothReference) -> Script:
        """Wait until these references have reached their targets."""
        return self.clock.until_arrived(*references)

    # Notes and pushes.

    def note(self, text: str) -> None:
        """Add a text to the report."""
        self.notes.append(text)
        self.note_time = self.clock.time

    def request_push(self, impulse: np.ndarray) -> None:
        """Request a push on the torso now; a simulation grants it, a real robot never gets it.

        Args:
            impulse: (3,) per kg of the robot, standing frame, N·s/kg.
        """
        self.pushes.append(np.array(impulse, dtype=float))

    # Whole-body references.

    def turn_trunk(self, turn: Sequence[float] | np.ndarray, duration: float = 1.0) -> None:
        """Turn the upper trunk from upright; waist and hips share the rotation.

        Args:
            turn: (3,) rotation vector, standing frame: roll, pitch, yaw for small ones, rad.
            duration: s, at least.

        Raises:
            MotionError: the hips' share would tilt the pelvis so far that it counts as a fall.
        """
        turn = np.asarray(turn, dtype=float)
        hips = self.upper_body.hips_share(turn)
        tilt = float(np.hypot(hips[0], hips[1]))
        if tilt > MAX_PELVIS_TILT:
            raise MotionError(
                f"turning the trunk so far tilts the pelvis by {np.degrees(tilt):.0f}°: at most "
                f"{np.degrees(MAX_PELVIS_TILT):.0f}°, more nearly counts as a fall"
            )
        time = self.torso.move_to(turn, duration)
        self.pelvis.move_to(hips, time)

    def go_to_posture(self, posture: PostureSolution, duration: float = 1.0) -> None:
        """Move to a whole-body posture: CoM, trunk and joints together.

        Args:
            posture: a solution of `PostureIK.solve`.
            duration: s, at least.
        """
        time = self.posture.move_to(posture.q[7:], duration)
        self.com.move_to(posture.com, time)
        self.torso.move_to(posture.torso, time)
        self.pelvis.move_to(posture.pelvis, time)

    def home_upper_body(self, duration: float = 1.0) -> None:
        """Send posture, trunk, CoM and hands home, without waiting; the feet continue."""
        for reference in self._upper_body_references():
            reference.move_to(reference.home, duration)
        self.hands.release(0.5 * duration)

    def home_all(self, duration: float = 1.0) -> None:
        """Send everything home, without waiting; walking ends."""
        self.walker.halt()
        self.home_upper_body(duration)

    def settle_upper_body(self, duration: float = 1.0) -> Script:
        """Bring posture, trunk, CoM and hands home unless they are; the feet continue."""
        if not self._upper_body_at_home():
            self.home_upper_body(duration)
            yield from self.until(self._upper_body_at_home)

    def go_home(self, duration: float = 1.0) -> Script:
        """Bring everything back to standing, from wherever it is."""
        yield from self.release_override()
        self.home_all(duration)
        yield from self.feet.stand(duration)
        yield from self.until(lambda: self.at_home)

    # Controller override.

    def start_override(self, override: ControllerOverride) -> None:
        """Let another controller compute the commands from this tick on, until `resume_walker`."""
        self.override = override

    def release_override(self) -> Script:
        """Bring the override to an end, if there is one, and let the walker resume."""
        override = self.override
        if override is not None:
            override.abandon()
            yield from self.until(lambda: override.done)
            self.resume_walker()

    def resume_walker(self) -> None:
        """Let the walker balance again, from the present state, both soles on the ground.

        The walker is reset there. The references start from the position and the velocity that
        the robot has, and go home.
        """
        assert self.state is not None
        self.override = None
        self.walker.resume(self.state)
        for reference in self._upper_body_references():
            reference.reset()
        self.feet.reset()
        self._bring_com_home()
        self.posture.start_from(self.state.q[7:], self.state.v[6:])
        self.posture.move_to(self.posture.home, _HANDOVER_TIME)

    def _bring_com_home(self) -> None:
        """Bring the CoM home from its present position and velocity."""
        kin, feet = self.walker.kinematics, self.walker.feet
        to_heading = planar_rotation(-self.walker.heading)
        offset = (ground_point(kin.p_com) - feet.middle) * to_heading
        velocity = ground_point(kin.v_com) * to_heading
        self.com.start_from(
            np.array([offset.real, offset.imag, 0.0]),
            np.array([velocity.real, velocity.imag, float(kin.v_com[2])]),
        )
        self.com.move_to(0.0, 1.0)

    # The tick; called by the player.

    def begin_tick(self, estimate: Estimate) -> None:
        """Take the tick's estimate, before the script runs."""
        self._estimate = estimate

    def advance(self) -> None:
        """Advance the references by a tick and hand them to the walker."""
        self.clock.advance()
        for reference in self._upper_body_references():
            reference.advance(self.dt)
        self.feet.advance(self.dt)
        self._write_offset()
        self.hands.advance(self.dt)
        posture = self.walker.posture
        posture.target = self._bounded(self.posture.value)
        posture.velocity = self.posture.velocity
        posture.acceleration = self.posture.acceleration
        self.feet.apply()

    def _write_offset(self) -> None:
        offset, weight_shift = self._offset, self.stance.weight_shift
        offset.com, offset.com_velocity = self.com.value, self.com.velocity
        offset.com_acceleration = self.com.acceleration
        offset.weight_shift = float(weight_shift.value[0])
        offset.weight_shift_velocity = float(weight_shift.velocity[0])
        offset.weight_shift_acceleration = float(weight_shift.acceleration[0])
        for rotation, reference in ((offset.torso, self.torso), (offset.base, self.pelvis)):
            rotation.is_zero = reference.at_home
            rotation.vector, rotation.rate = reference.value, reference.velocity
            rotation.acceleration = reference.acceleration

    def _bounded(self, posture: np.ndarray) -> np.ndarray:
        """Bound the posture error of arms and trunk, for which the CoM would pay.

        A joint whose torque does not suffice stays behind; what it asks for must stay bounded.
        """
        if self.state is None:
            return posture
        error = posture - self.state.q[7:]
        far = self._not_legs & (np.abs(error) > _MAX_POSTURE_ERROR)
        if not far.any():
            return posture
        bounded = np.clip(error, -_MAX_POSTURE_ERROR, _MAX_POSTURE_ERROR)
        return np.where(far, self.state.q[7:] + bounded, posture)

    def reference(self) -> MotionReference:
        """Return what the references commit to at this tick."""
        com = None
        if self.override is None and self.stance.at_rest:
            com = self.com.value + np.array([0.0, 0.0, self.walker.height])
        weight_shift = float(self.stance.weight_shift.value[0])
        return MotionReference(weight_shift, com, self.hands.targets)

    def end_tick(self, command: Command) -> None:
        """Take the tick's command, after the controller."""
        self.last_torque = command.tau
        self.feet.observe()
