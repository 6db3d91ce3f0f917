"""Swing feet that a blow throws off their way, or that are in the air when their swing begins."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from wbc.gait import GaitState, SwingFoot
from wbc.gait.footsteps import SIDES
from wbc.kinematics import Kinematics
from wbc.robot import Robot
from wbc.walking.swing_task import SwingTask

_FASTER = 1.2  # times √(g h) by which a foot is faster than its reference, to be knocked
_STILL_FASTER = 0.4  # the same of one that was knocked already
_ABOVE = 0.12  # share of the CoM's height by which a foot is above its reference, likewise
_BRAKING = 2.0  # times what a leg can give its foot, with which one that is followed goes on
_LEAST_REMAINING = 0.1  # s that the swing then has left, at least
_LANDING = 0.03  # s before touchdown from which on a foot is left alone
_LANDING_HEIGHT = 0.06  # share of the CoM's height up to which it is


class KnockedFoot:
    """Lets the reference of a swing foot begin anew with the motion that a blow has given the foot.

    A blow on a leg gives its foot some metres per second and throws it as far as a metre off its
    way. To get it back there at once, its task asks for several times what the leg's torques give
    it. The hip then gives all it has, whatever turns the trunk, for the ground could not take up
    the reaction either: a foot that accelerates by a moves the centroidal moment pivot by κ a (see
    `SwingMomentum`), 8 g by two fifths of a metre. So a foot for which more is asked than its leg
    can do, and which moves faster than its reference by some metres per second or is far above it
    (one that lags is slower, and not above), is followed: its way to the landing place goes on from
    where it is and how fast it is, the step is a quick one, lasts as long as its leg takes
    (`PushRecovery`), and lands where it catches the DCM by then. It goes on with twice the
    acceleration that its leg can give it for long: what slows it down while the blow lasts is way
    that it need not come back.

    While the support foot has no contact, nothing holds the body, and both feet fly: then, and when
    the foot is about to land, it is left alone. So it is by a walker without a recovery gait, which
    makes no quick steps.

    After a blow, robots often have no foot on the ground when a quick step begins: the foot that
    then swings moves along with the body, at 1.5 m/s after a heavy punch. Its swing begins with the
    velocity that it has. A reference that begins at rest would first stop the foot, and leave it
    as far behind the body as half a step.

    Args:
        robot: the robot.
        tasks: those of the feet in the air, one per sole.
        acceleration: the largest that a leg's torques give its foot, m/s².
    """

    def __init__(self, robot: Robot, tasks: Sequence[SwingTask], acceleration: float) -> None:
        # A task has its frame from the first swing on.
        self._feet: dict[str, tuple[int, SwingTask]] = {
            sole.side: (sole.frame_id, task) for sole, task in zip(robot.soles, tasks, strict=True)
        }
        self._acceleration = acceleration
        self._speed = math.sqrt(robot.gravity * robot.com_height)
        self._landing_height = _LANDING_HEIGHT * robot.com_height
        self._above = _ABOVE * robot.com_height

    def update(
        self,
        state: GaitState,
        kin: Kinematics,
        speeds: tuple[float, float],
        contacts: frozenset[str] | None,
    ) -> None:
        """Begin the reference of the swing foot with the foot's motion, if it is not at rest.

        Args:
            state: whose `swing`, and whose `shortened` and `duration` if the foot was knocked, it
                sets.
            kin: kinematics of this tick.
            speeds: of the left and of the right sole, m/s.
            contacts: sides of the soles that touch the ground; None when it is not measured: then
                nothing is followed.
        """
        swing = state.swing
        if not isinstance(swing, SwingFoot) or contacts is None or state.hop is not None:
            return
        if state.time == 0.0 and state.is_quick and state.swing_side not in contacts:
            frame_id, _ = self._feet[state.swing_side]
            v_x, v_y, *_ = kin.motion(frame_id).velocity.tolist()
            swing.start_moving(complex(v_x, v_y))
        if state.support not in contacts or state.recovery_gait is state.normal_gait:
            return
        speed = speeds[SIDES.index(state.swing_side)]
        if not self._is_thrown(swing, speed, state.other_foot.height):
            return
        lands = (
            state.remaining <= _LANDING
            and state.other_foot.height - state.landing.height <= self._landing_height
        )
        if lands and not swing.knocked:
            return
        frame_id, task = self._feet[state.swing_side]
        sole = kin.motion(frame_id)
        asked = task.feedback(swing, sole)
        size = float(np.linalg.norm(asked))
        if size <= self._acceleration:
            return
        braking = asked * (_BRAKING * self._acceleration / size)
        swing.follow(sole.position, sole.velocity[:3], braking)
        state.shortened = True
        state.duration = max(state.duration, state.time + _LEAST_REMAINING)

    def _is_thrown(self, swing: SwingFoot, speed: float, height: float) -> bool:
        """Whether a foot with a speed (m/s) at a height (m) is one that a blow has thrown.

        A blow of half the force gives it less speed than a foot may have that hurries after its
        reference; but none that hurries is far above it.
        """
        least = (_STILL_FASTER if swing.knocked else _FASTER) * self._speed
        if speed > least and speed - np.linalg.norm(swing.motion.velocity[:3]) > least:
            return True
        return height - float(swing.motion.position[2]) > self._above
