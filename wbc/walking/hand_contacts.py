"""Hands that push against the environment, and what their forces do to the balance."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pinocchio as pin

from wbc.contacts import PointContact
from wbc.errors import ContactError
from wbc.gait import DcmReference
from wbc.kinematics import Kinematics
from wbc.robot import Robot


class HandContact:
    """A point of a hand through which the environment acts on the robot with a force.

    The force is one of the controller's unknowns: it lies in the friction cone about the normal,
    and its normal component between `min_force` and `max_force`. With both equal it is a known
    force: that of an object which is pushed, or the weight of a payload.

    Args:
        frame: name of the hand's frame.
        normal: (3,) direction of the normal force on the hand, out of the surface; world axes.
        point: (3,) the point in the frame's axes, m.
        friction: Coulomb coefficient that the controller counts on.
        motion_weight: weight of the point's being at rest; small where it moves with an object.
        name: unique within a controller.

    Attributes:
        contact: the contact, with its force limits.

    Raises:
        ContactError: the normal is zero or not finite, or see `Contact`.
    """

    def __init__(
        self,
        frame: str,
        normal: np.ndarray,
        *,
        point: np.ndarray | None = None,
        friction: float = 0.5,
        motion_weight: float = 300.0,
        name: str = "",
    ) -> None:
        self._axes = axes_about(np.asarray(normal, dtype=float))
        self._point = np.zeros(3) if point is None else np.array(point, dtype=float)
        self.contact = PointContact(
            frame,
            placement=pin.SE3(self._axes, self._point),
            friction=friction,
            motion_weight=motion_weight,
            max_force=0.0,
            name=name or f"{frame}_contact",
        )

    @property
    def normal(self) -> np.ndarray:
        """(3,) normal, world axes."""
        return self._axes[:, 2].copy()

    @property
    def known(self) -> bool:
        """Whether the normal force is given, rather than chosen by the controller."""
        return self.contact.min_force == self.contact.max_force

    def set_force(self, least: float, most: float) -> None:
        """Set the limits of the normal force, N.

        Raises:
            ContactError: not 0 ≤ least ≤ most.
        """
        if not 0.0 <= least <= most < math.inf:
            raise ContactError(
                f"contact '{self.contact.name}': need 0 ≤ least ({least}) ≤ most ({most}) force, N"
            )
        self.contact.min_force, self.contact.max_force = least, most

    def place(self, kin: Kinematics) -> np.ndarray:
        """Turn the contact's axes with the hand; return the point (3,), world axes, m."""
        frame = kin.frame(self.contact.frame_id)
        self.contact.placement = pin.SE3(frame.rotation.T @ self._axes, self._point)
        return np.asarray(frame.act(self._point))

    def extreme_forces(self) -> np.ndarray:
        """Return the corners of the friction pyramid at the largest normal force, (4, 3), N."""
        tangential = self.contact.friction / math.sqrt(2.0)
        corners = [(a * tangential, b * tangential, 1.0) for a, b in product((-1, 1), (-1, 1))]
        return np.asarray(self.contact.max_force * np.array(corners) @ self._axes.T)


class HandContacts:
    """The hand contacts of a walker, and how far they move the centroidal moment pivot.

    A force F on the hand at r moves the pivot e of the linear inverted pendulum
    `c̈ = ω² (c − e)` off the ZMP p by

        δ = [ (r − c) F_z − (r_z − z_ground) F ] / (m g)    (horizontal components),

    from the moments about the ground point below the centre of mass c, with the ZMP that of the
    soles alone. Known forces shift the reference of the DCM by δ. The others enlarge the area in
    which the stabilizer may place the pivot: the sum of the support polygon and the hull of their
    δ (the ZMP support area of S. Caron, Q.-C. Pham, Y. Nakamura, *ZMP support areas for
    multi-contact mobility under frictional constraints*, T-RO 2017, with the hand's friction
    pyramid cut off at `max_force`).

    Args:
        robot: the robot.

    Attributes:
        offset: δ of the known and the least forces, world axes, m.
        extension: what the other forces may add to it, corners, world axes, m; empty for nothing.
        contacts: the contacts, for the controller.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._hands: tuple[HandContact, ...] = ()
        self.contacts: tuple[PointContact, ...] = ()
        self.offset = 0j
        self.extension: tuple[complex, ...] = ()

    @property
    def known(self) -> bool:
        """Whether all forces are known."""
        return all(hand.known for hand in self._hands)

    def add(self, hand: HandContact) -> HandContact:
        """Add a contact, from the next tick on.

        Raises:
            ContactError: there is one of that name.
            FrameNotFound: the robot has no such frame.
        """
        if hand.contact.name in {other.contact.name for other in self._hands}:
            raise ContactError(f"there is a hand contact '{hand.contact.name}' already")
        hand.contact.bind(self._robot)
        self._set((*self._hands, hand))
        return hand

    def remove(self, hand: HandContact) -> None:
        """Remove a contact, if it is there."""
        self._set(tuple(other for other in self._hands if other is not hand))

    def clear(self) -> None:
        """Remove all contacts."""
        self._set(())

    def _set(self, hands: tuple[HandContact, ...]) -> None:
        self._hands = hands
        self.contacts = tuple(hand.contact for hand in hands)
        if not hands:
            self.offset, self.extension = 0j, ()

    def update(self, kin: Kinematics, ground: float) -> None:
        """Compute `offset` and `extension`.

        Args:
            kin: present state.
            ground: height of the ground under the soles, m.
        """
        self.offset, corners = 0j, [0j]
        for hand in self._hands:
            lever = hand.place(kin) - kin.p_com
            lever[2] += kin.p_com[2] - ground
            least = self._shift(lever, hand.contact.min_force * hand.normal)
            self.offset += least
            if not hand.known:
                added = [self._shift(lever, force) - least for force in hand.extreme_forces()]
                corners += [corner + a for corner in corners for a in added]
        self.extension = tuple(corners) if len(corners) > 1 else ()

    def apply(self, reference: DcmReference) -> DcmReference:
        """Return the planner's reference, shifted by `offset`; the ZMP stays where it is."""
        moved, pivot = reference.dcm + self.offset, reference.cmp_offset + self.offset
        return DcmReference(moved, reference.dcm_velocity, reference.zmp, pivot)

    def _shift(self, lever: np.ndarray, force: np.ndarray) -> complex:
        x, y, z = lever.tolist()
        fx, fy, fz = force.tolist()
        return complex(x * fz - z * fx, y * fz - z * fy) / self._robot.weight


def axes_about(normal: np.ndarray) -> np.ndarray:
    """Return axes (3, 3) whose z is along a normal, and whose x is as horizontal as can be.

    Raises:
        ContactError: the normal is zero or not finite.
    """
    length = float(np.linalg.norm(normal)) if normal.shape == (3,) else 0.0
    if not 0.0 < length < math.inf:
        raise ContactError(f"a contact normal of {normal} must be three finite numbers, not zero")
    z = normal / length
    across = np.cross([0.0, 0.0, 1.0], z)
    if np.linalg.norm(across) < 1e-3:
        across = np.array([1.0, 0.0, 0.0]) - z[0] * z
    x = across / np.linalg.norm(across)
    return np.column_stack((x, np.cross(z, x), z))
