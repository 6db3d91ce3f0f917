"""Contact manager: the controller's contacts and swing task for the phase of the gait."""

from __future__ import annotations

import math

import numpy as np

from wbc.contacts import Contact, PointContact, SurfaceContact
from wbc.controller import WholeBodyController
from wbc.gait import STAND, SWING, TRANSFER, GaitState, LiftedFoot, SwingFoot
from wbc.gait.footsteps import SIDES
from wbc.robot import Robot, Sole
from wbc.robot.posture import has_soles
from wbc.walking.gains import WalkerGains
from wbc.walking.hand_contacts import HandContacts
from wbc.walking.swing_task import SwingTask
from wbc.walking.tipping_foot import TippingFoot

_HIGH = 0.03  # m, height above which a lifted foot need not be flat
_FREE = 0.01  # share of the weight of the flatness in the first half of a fast swing
_FLAT_FROM, _FLAT_AT = 0.5, 0.8  # share of the swing from which, and at which, it is whole again
_ON_TIME = 3.0  # times its weight that the height of a foot in a quick step has
_THROWN_UP = 0.12  # times √(g h) by which the CoM rises when a blow throws the robot up
_STANDING = 0.2  # times √(g h), the speed up to which a foot in contact stands, after a blow
_LOOSE = 0.1  # square root of the share of the weight that its flatness keeps


class ContactManager:
    """Keeps the controller's contacts and swing tasks in step with the gait.

    The support foot is held exactly, so that it carries the QP's elimination; the other one in
    double support by a high weight, because two exact feet and a stretched knee may have no
    solution. A foot whose leg has fewer joints than that takes is always held by the weight: the
    leg cannot turn it against all moments of the robot's motion, which would need a wrench beyond
    the sole's edges. So is the support foot of a quick step, unless a blow has thrown its swing
    foot off its way while it stands itself: in the air as well, it would be held there by forces
    that no ground gives, which fling its leg away. While a blow throws the robot up, it carries no
    more than the weight: what holds it exactly under a trunk that turns is friction, for which the
    QP would press it on the ground with twice the weight, and throw the robot off. A support foot
    that tips is held by an edge of its sole until the other one has landed, as long as it stands:
    held exactly in the air, it would carry several times the weight in the QP, and throw the robot
    up as it lands. After such a blow contact alone does not make a foot stand: one that was taken
    along bounces, and held exactly in each of the ticks in which it touches the ground it carries
    nothing in them, because it would have to stop at once. A foot that hops is held exactly while
    it thrusts, and not at all while it flies. Towards the end of double support the leaving foot is
    unloaded.

    Args:
        robot: the robot.
        controller: gets the contacts and the swing tasks.
        gains: the walker's.
        hands: hands in contact.
    """

    def __init__(
        self,
        robot: Robot,
        controller: WholeBodyController,
        gains: WalkerGains,
        hands: HandContacts,
    ) -> None:
        self._controller = controller
        self._hands = hands
        self._gains = gains
        self._weight = robot.weight
        speed = math.sqrt(robot.gravity * robot.com_height)
        self._thrown_up, self._standing = _THROWN_UP * speed, _STANDING * speed
        self._contacts: dict[str, Contact] = {}
        self._support_weight: dict[str, float | None] = {}
        self._swing_tasks: dict[str, SwingTask] = {}
        self._tipping: dict[str, TippingFoot] = {}
        self._tips = False  # whether a foot does, or did at the last tick
        # Weights of the feet in the air that are not the usual one; the controller has their tasks.
        self._tracked: dict[str, np.ndarray | None] = {}
        self._has_soles = has_soles(robot.soles)
        self._usual_weight: float | np.ndarray = gains.swing_weight
        if not self._has_soles:
            self._usual_weight = _place_weight(gains.swing_weight)
        self._quick_weight = self._recovery_weight(gains.swing_recovery_share)
        self._step_out_weight = self._recovery_weight(1.0)
        self._knocked_weight = self._loose_weight()
        for sole, leg in zip(robot.soles, robot.legs, strict=True):
            contact = _contact(sole, gains)
            contact.bind(robot)
            self._contacts[sole.side] = contact
            if self._has_soles:
                self._tipping[sole.side] = TippingFoot(sole, controller, gains)
            lacks_joints = len(leg) < contact.motion_size
            self._support_weight[sole.side] = gains.second_contact_weight if lacks_joints else None
            self._swing_tasks[sole.side] = SwingTask(
                sole.name, weight=self._usual_weight, kp=gains.swing_kp
            )

    @property
    def swing_tasks(self) -> tuple[SwingTask, ...]:
        """One per foot; the controller has those of the feet in the air."""
        return tuple(self._swing_tasks.values())

    def update(
        self, state: GaitState, touching: frozenset[str] | None, speeds: tuple[float, float]
    ) -> None:
        """Set contacts and swing tasks for the present phase.

        Args:
            state: phase, feet and what is planned.
            touching: sides of the soles that touch the ground; None when it is not measured: then
                the support foot counts as standing.
            speeds: of the left and of the right sole, m/s.
        """
        support = self._contacts[state.support]
        other = self._contacts[state.swing_side]
        support.motion_weight = self._support_weight[state.support]
        support.max_force = other.max_force = math.inf
        self._track_feet(state)
        if state.tipping != 0j or self._tips:
            self._tips = state.tipping != 0j
            for side, foot in self._tipping.items():
                foot.update(state.tipping if side == state.support else 0j, state.stance)
        if state.hop is not None:
            self._hold(() if state.hop.flies else (support,))
            return
        knocked = state.swing_is_knocked
        bounces = knocked and speeds[SIDES.index(state.support)] > self._standing
        stands = touching is None or (state.support in touching and not bounces)
        if state.is_quick and not (knocked and stands):
            support.motion_weight = self._gains.second_contact_weight
            if state.vertical_velocity > self._thrown_up:
                support.max_force = self._weight
        if state.phase is SWING:
            if state.tipping != 0j and stands and self._has_soles:
                edge = self._tipping[state.support].contact(state.tipping)
                # A foot that tips has given way already: its edge stays where it is.
                edge.motion_weight = self._support_weight[state.support]
                support = edge
            self._hold((support,))
            return
        other.motion_weight = self._gains.second_contact_weight
        if state.phase is STAND:
            if state.other_foot_load < 1.0:
                other.max_force = max(state.other_foot_load * self._weight, 1.0)
        elif state.phase is TRANSFER and not state.stopping:
            left_over = (1.0 - state.progress) / (1.0 - self._gains.unload_from)
            if left_over < 1.0:
                other.max_force = max(left_over * 0.5 * self._weight, 1.0)
        self._hold((support, other))

    def _hold(self, contacts: tuple[Contact, ...]) -> None:
        if self._hands.contacts:
            contacts = (*contacts, *self._hands.contacts)
        if contacts != self._controller.contacts:  # which checks what it is given
            self._controller.contacts = contacts

    def _track_feet(self, state: GaitState) -> None:
        side, swing = state.swing_side, state.swing
        hopping = None if state.hop is None else state.hop.foot
        if hopping is None:
            self._untrack(state.support)
        if swing is None:
            self._untrack(side)
        else:
            self._track(side, swing, self._special_weight(state))
        if hopping is not None:
            self._track(state.support, hopping, self._quick_weight)

    def _track(self, side: str, foot: SwingFoot | LiftedFoot, weight: np.ndarray | None) -> None:
        """Have a foot follow its reference, with a weight; None is the usual one."""
        task = self._swing_tasks[side]
        if side not in self._tracked:
            self._controller.add(task)
            self._tracked[side] = None
        if weight is not self._tracked[side]:
            task.weight = self._usual_weight if weight is None else weight
            self._tracked[side] = weight
        task.foot = foot

    def _untrack(self, side: str) -> None:
        if side not in self._tracked:
            return
        task = self._swing_tasks[side]
        if self._tracked.pop(side) is not None:
            task.weight = self._usual_weight
        self._controller.remove(task)

    def _special_weight(self, state: GaitState) -> np.ndarray | None:
        """Return the (6,) weight of a foot that does not have the usual one, else None."""
        if state.lifted is not None:
            return self._held_weight(float(state.lifted.offset[2]))
        if state.swing_is_knocked:
            return self._knocked_weight
        if state.is_quick:
            return self._step_out_weight if state.steps_out else self._quick_weight
        if state.fast_share > 0.0 and self._has_soles:
            return self._fast_weight(state)
        return None

    def _fast_weight(self, state: GaitState) -> np.ndarray:
        """Return the (6,) task weight of a foot in a swing of fast walking.

        The shank of a leg that is thrown ahead leans farther than the ankle bends: kept flat, the
        foot would take from the trunk and from the CoM what the ankle lacks.
        """
        s = (state.progress - _FLAT_FROM) / (_FLAT_AT - _FLAT_FROM)
        free = state.fast_share * (1.0 - min(max(s, 0.0), 1.0))
        return _tilting_weight(self._gains.swing_weight, _FREE**free)

    def _recovery_weight(self, share: float) -> np.ndarray:
        """Return the (6,) task weight of a foot in a quick step; its place has a share of its own.

        The ground turns it flat when it lands. Kept level in the air, an ankle at its stop holds
        the whole leg back: that of G1 rolls by 15°, less than a wide step asks for. Only its pitch
        is kept, for a toe that hangs down scuffs the ground on the way. Where the place is out of
        reach, a foot that is on the ground in time is worth more than one that is nearer to it.
        """
        place = share * self._gains.swing_weight
        if not self._has_soles:
            return _place_weight(place)
        turn = self._gains.swing_recovery_turn_share * self._gains.swing_weight
        return np.array((place, place, _ON_TIME * place, turn, place, turn))

    def _loose_weight(self) -> np.ndarray:
        """Return the (6,) task weight of a foot that a blow has thrown off its way.

        To stop it takes what its leg has, and the trunk must not be turned for it, least of all for
        how the foot is turned: the blow has thrown its ankle against a stop.
        """
        weights = _place_weight(self._gains.swing_weight)
        if self._has_soles:
            weights[3:] = self._gains.swing_recovery_turn_share * self._gains.swing_weight
        return weights

    def _held_weight(self, height: float) -> np.ndarray:
        """Return the (6,) task weight of a foot that is held up at a height, m.

        High above the ground it need not be flat: an ankle at its limit would move the CoM.
        """
        flat = max(1.0 - height / _HIGH, _LOOSE)
        return _tilting_weight(self._gains.swing_weight, flat * flat)


def _contact(sole: Sole, gains: WalkerGains) -> Contact:
    """Return the contact of a sole: a surface, or a point without any area to press on."""
    if has_soles((sole, sole)):
        return SurfaceContact.from_sole(sole, margin=gains.sole_margin, friction=gains.friction)
    return PointContact(sole.name, friction=gains.friction)


def _tilting_weight(weight: float, flatness: float) -> np.ndarray:
    """Return the (6,) weight of a foot in the air whose flatness keeps a share of it."""
    weights = np.full(6, weight)
    weights[3:5] *= flatness
    return weights


def _place_weight(weight: float) -> np.ndarray:
    """Return the (6,) weight of a foot that need not be turned."""
    return np.array([weight] * 3 + [0.0] * 3)
