"""References of hands in contact: touching a surface, pressing against it, letting go."""

from __future__ import annotations

import numpy as np

from wbc.errors import MotionError
from wbc.estimation import Estimate, HandForceEstimator, PayloadEstimator
from wbc.motions.engine.clock import Script, ScriptClock
from wbc.motions.engine.hands import HandReferences
from wbc.motions.engine.reference import SmoothReference
from wbc.robot.upper_body import Side, UpperBody
from wbc.walking import HandContact, Walker

_TOUCH_SHARE = 0.008  # of the robot's weight: a force on the hand that is no noise
_TOUCH_TIME = 0.02  # s for which it has to last
_SETTLE_TIME = 0.3  # s until the force is known after the observer's start
_NO_FRICTION = 1e-3
_FREE = 1e-6  # weight of the motion of a hand that nothing holds
_BACK = 0.06  # m by which the hand leaves a surface


class _HeldContact:
    """A hand contact with the references of its force limits."""

    def __init__(self, contact: HandContact, weight: float) -> None:
        self.contact = contact
        self.ends = False
        self.payload: PayloadEstimator | None = None
        self.limits = SmoothReference(np.zeros(2), speed=weight, acceleration=20.0 * weight)


class HandContactReferences:
    """Brings hands into contact, loads and unloads them, and feels the force on them.

    Args:
        walker: the walker, whose balance counts on the contacts.
        clock: clock of the scripts.
        upper_body: arms of its robot.
        hands: leads the hands to the surface.
    """

    def __init__(
        self, walker: Walker, clock: ScriptClock, upper_body: UpperBody, hands: HandReferences
    ) -> None:
        self._walker, self._clock, self._hands = walker, clock, hands
        self._upper_body = upper_body
        self._weight = walker.robot.weight
        self._held: dict[Side, _HeldContact] = {}
        self._observers: dict[Side, HandForceEstimator] = {}

    def reset(self) -> None:
        """Remove all contacts at once."""
        for held in self._held.values():
            self._walker.hand_contacts.remove(held.contact)
        self._held.clear()
        self._observers.clear()

    @property
    def engaged(self) -> bool:
        """Whether a hand is in contact."""
        return bool(self._held)

    def feel(self, side: str, point: np.ndarray | None = None) -> None:
        """Observe the force on a hand, from the next tick on.

        Args:
            side: "left" or "right".
            point: (3,) where it acts, in the axes of the hand's frame, m; its origin if None.

        Raises:
            MotionError: the robot has no such arm.
        """
        arm = self._upper_body.arm(side)
        robot, dt = self._walker.robot, self._clock.dt
        self._observers[arm.side] = HandForceEstimator(robot, dt, arm.hand, arm.joints, point=point)

    def force(self, side: str) -> np.ndarray:
        """Return the (3,) observed force on a hand, world axes, N; zero unless it is observed."""
        observer = self._observers.get(self._upper_body.arm(side).side)
        return np.zeros(3) if observer is None else observer.force.copy()

    def touch(
        self,
        side: str,
        normal: np.ndarray,
        *,
        point: np.ndarray,
        speed: float = 0.05,
        distance: float = 0.2,
        friction: float = 0.5,
    ) -> Script:
        """Move a hand against a surface until it feels it, and make it a contact without force.

        Args:
            side: "left" or "right".
            normal: (3,) of the surface, towards the robot, standing frame.
            point: (3,) of the hand that touches, in the axes of the hand's frame, m.
            speed: m/s.
            distance: within which the surface must be, m.
            friction: Coulomb coefficient to count on.

        Raises:
            MotionError: there is no surface, the hand is in contact already, or the robot has no
                such arm.
        """
        arm = self._upper_body.arm(side)
        self._check_free(arm.side)
        self.feel(side, point)
        yield from self._clock.wait(_SETTLE_TIME)
        free = self.force(side)  # of a hand that touches nothing: what the model does not know
        frame = self._walker.standing_frame
        world = frame.rotation @ normal
        start, step = self._hands.position(side), -speed * np.asarray(normal)
        self._hands.follow(side, lambda t: start + t * step)
        least = _TOUCH_SHARE * self._weight
        end, felt_since = self._clock.time + distance / speed, None
        while felt_since is None or self._clock.time < felt_since + _TOUCH_TIME:
            if float((self.force(side) - free) @ world) < least:
                felt_since = None
            elif felt_since is None:
                felt_since = self._clock.time
            if self._clock.time > end:
                raise MotionError(
                    f"the {side} hand feels no surface within {100.0 * distance:.0f} cm"
                )
            yield
        contact = HandContact(
            arm.hand, world, point=point, friction=friction, name=f"{side}_hand_contact"
        )
        self._held[arm.side] = _HeldContact(contact, self._weight)
        self._walker.hand_contacts.add(contact)
        self._hands.release(0.3, side)

    def carry(self, side: str) -> None:
        """Carry a payload of unknown mass in a hand, from the next tick on.

        Its estimated weight is a known force on the hand: the arm bears it, and the balance counts
        on it.

        Raises:
            MotionError: the hand is in contact already, or the robot has no such arm.
        """
        arm = self._upper_body.arm(side)
        self._check_free(arm.side)
        self.feel(side)
        down = np.array([0.0, 0.0, -1.0])
        contact = HandContact(
            arm.hand,
            down,
            friction=_NO_FRICTION,
            motion_weight=_FREE,
            name=f"{side}_hand_payload",
        )
        held = self._held[arm.side] = _HeldContact(contact, self._weight)
        held.payload = PayloadEstimator(self._walker.robot, self._clock.dt)
        self._walker.hand_contacts.add(contact)

    def payload(self, side: str) -> float:
        """Return the estimated mass of the payload in a hand, kg; 0 without one."""
        held = self._held.get(self._upper_body.arm(side).side)
        return 0.0 if held is None or held.payload is None else held.payload.mass

    def payload_settled(self, side: str) -> bool:
        """Whether the mass of the payload in a hand has been observed for long enough."""
        held = self._held.get(self._upper_body.arm(side).side)
        return held is None or held.payload is None or held.payload.settled

    def _check_free(self, side: Side) -> None:
        if side in self._held:
            raise MotionError(f"the {side} hand is in contact already")

    def load(self, side: str, least: float, most: float, duration: float = 0.5) -> Script:
        """Change the limits of a contact's normal force within a time.

        Args:
            side: "left" or "right".
            least: force that the hand exerts at least, N.
            most: force that balance may count on, N.
            duration: s.
        """
        limits = self._contact(side).limits
        limits.move_to(np.array([least, most]), duration)
        yield from self._clock.until_arrived(limits)

    def load_all(self, least: float, most: float, duration: float = 0.5) -> Script:
        """Change the limits of the normal forces of all contacts; see `load`."""
        limits = [held.limits for held in self._held.values()]
        for reference in limits:
            reference.move_to(np.array([least, most]), duration)
        yield from self._clock.until_arrived(*limits)

    def let_move(self, side: str) -> None:
        """Let a hand go along with what it touches, led by its reference in the standing frame."""
        self._contact(side).contact.contact.motion_weight = _FREE
        self._hands.reach(side, self._hands.position(side))

    def release(self, side: str, duration: float = 0.5) -> Script:
        """Unload a hand within a time, s, and take it off the surface."""
        held = self._contact(side)
        yield from self.load(side, 0.0, 0.0, duration)
        self._walker.hand_contacts.remove(held.contact)
        del self._held[self._upper_body.arm(side).side]
        normal = self._walker.standing_frame.rotation.T @ held.contact.normal
        self._hands.reach(side, self._hands.position(side) + _BACK * normal, duration)
        yield from self._clock.wait(duration)

    def let_go(self, duration: float) -> None:
        """Unload all hands within a time, s, without waiting; each contact ends when it is free."""
        for held in self._held.values():
            held.limits.move_to(0.0, duration)
            held.ends = True
        self._observers.clear()

    def _contact(self, side: str) -> _HeldContact:
        held = self._held.get(self._upper_body.arm(side).side)
        if held is None:
            raise MotionError(f"the {side} hand is in no contact")
        return held

    def observe(self, estimate: Estimate, torque: np.ndarray) -> None:
        """Take in the estimate and the torques, (na,) N·m, of the tick that the walker has made."""
        kin = self._walker.kinematics
        for observer in self._observers.values():
            observer.update(kin, torque)
        for side, held in self._held.items():
            if held.payload is not None and not held.ends:
                mass = held.payload.update(estimate, kin, self._observers[side].force)
                weight = mass * self._walker.robot.gravity
                held.limits.start_from(np.array([weight, weight]), np.zeros(2))

    def advance(self, dt: float) -> None:
        """Advance by a tick of dt, s."""
        for side, held in tuple(self._held.items()):
            held.limits.advance(dt)
            if held.ends and held.limits.arrived:
                self._walker.hand_contacts.remove(held.contact)
                del self._held[side]
                continue
            least, most = np.maximum(held.limits.value, 0.0).tolist()
            held.contact.set_force(min(least, most), most)
