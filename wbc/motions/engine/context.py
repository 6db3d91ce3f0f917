"""The context of a motion's script: references of the whole body, and events to wait for."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from wbc.command import Command
from wbc.errors import MotionError
from wbc.estimation import Estimate
from wbc.ik.objective import PostureSolution
from wbc.ik.posture_checks import MAX_PELVIS_TILT
from wbc.motions.engine.body import BodyReferences
from wbc.motions.engine.clock import Script, ScriptClock
from wbc.motions.engine.feet import FootReferences
from wbc.motions.engine.hand_contacts import HandContactReferences
from wbc.motions.engine.hands import HandReferences
from wbc.motions.engine.motion_reference import MotionReference
from wbc.motions.engine.override import ControllerOverride
from wbc.motions.engine.reference import SmoothReference
from wbc.motions.engine.stance import Stance
from wbc.robot.upper_body import UpperBody
from wbc.state import State
from wbc.walking import Walker


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
        stance: supporting feet, and the position of the weight.
        feet: shifts the weight, lifts and places feet, steps.
        hands: leads the hands.
        hand_contacts: brings hands into contact, and feels the forces on them.
        body: references of CoM, trunk and joints, the next four.
        com: (3,) offset of the CoM from its place when standing, m; see `ComReference`.
        torso: (3,) rotation vector of the upper trunk from upright, standing frame, rad.
        pelvis: (3,) likewise of the root link; `turn_trunk` shares a rotation between both.
        posture: (na,) joint positions, rad. The legs follow only as far as balance lets them.
        notes: texts for the report.
        note_time: `clock.time` of the latest note, s.
        pushes: requested and not yet granted, (3,) N·s/kg each.
        payloads: likewise, frame of the hand and mass, kg.
        override: the controller that steps instead of the walker, or None.
        state: estimate of this tick; None before the first.
        last_torque: (na,) torques of the last tick, N·m; None before the first.
    """

    def __init__(self, walker: Walker) -> None:
        self.walker = walker
        self.robot = walker.robot
        self.upper_body = UpperBody.of(walker.robot)
        self.clock = ScriptClock(walker.dt)
        self.stance = Stance(walker)
        self.body = BodyReferences(walker, self.stance)
        self.com, self.torso = self.body.com, self.body.torso
        self.pelvis, self.posture = self.body.pelvis, self.body.posture
        self.feet = FootReferences(walker, self.clock, self.stance, self.com)
        self.hands = HandReferences(walker, self.upper_body)
        self.hand_contacts = HandContactReferences(walker, self.clock, self.upper_body, self.hands)
        self.notes: list[str] = []
        self.pushes: list[np.ndarray] = []
        self.payloads: list[tuple[str, float]] = []
        self.override: ControllerOverride | None = None
        self.last_torque: np.ndarray | None = None
        self._estimate: Estimate | None = None

    def __repr__(self) -> str:
        references = {**self.body.references, "weight": self.stance.weight_shift}
        away = [name for name, r in references.items() if not r.at_home]
        return (
            f"MotionContext({self.robot.name} at {self.time:.2f} s, "
            f"{'away from home: ' + ', '.join(away) if away else 'at home'})"
        )

    def reset(self) -> None:
        """Stand with every reference at home. The walker has just been reset."""
        self.clock.time = self.note_time = 0.0
        self.notes.clear()
        self.pushes.clear()
        self.payloads.clear()
        self.feet.reset()
        self.hands.reset()
        self.hand_contacts.reset()
        self.walker.velocity = (0.0, 0.0, 0.0)
        self.override = None
        self.body.reset()

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
        return self.body.state

    @property
    def standing(self) -> bool:
        """Whether both feet are on the ground and the robot is not about to walk."""
        return self.stance.standing

    @property
    def at_home(self) -> bool:
        """Whether the robot stands, with every reference at home."""
        return self.standing and self.feet.at_home and self._upper_body_at_home()

    def _upper_body_at_home(self) -> bool:
        return self.body.at_home and not (self.hands.engaged or self.hand_contacts.engaged)

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

    def request_payload(self, side: str, mass: float) -> None:
        """Request a payload in a hand now; a simulation grants it, a person may.

        Args:
            side: "left" or "right".
            mass: kg; 0 takes it away.

        Raises:
            MotionError: the robot has no such arm.
        """
        self.payloads.append((self.upper_body.arm(side).hand, float(mass)))

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
        self.body.move_home(duration)
        self.hand_contacts.let_go(0.5 * duration)
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

    def let_step(self) -> None:
        """Leave feet and weight to the walker at once, which has to step to keep its balance."""
        self.feet.reset()
        self.hand_contacts.reset()
        self.body.release_com()

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
        self.feet.reset()
        self.body.resume()

    # The tick; called by the player.

    def begin_tick(self, estimate: Estimate) -> None:
        """Take the tick's estimate, before the script runs."""
        self._estimate = estimate
        self.body.state = estimate.state

    def advance(self) -> None:
        """Advance the references by a tick and hand them to the walker."""
        self.clock.advance()
        self.body.advance(self.dt)
        self.feet.advance(self.dt)
        self.body.apply()
        self.hands.advance(self.dt)
        self.hand_contacts.advance(self.dt)
        self.feet.apply()

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
        if self._estimate is not None:
            self.hand_contacts.observe(self._estimate, command.tau)
        self.feet.observe()
