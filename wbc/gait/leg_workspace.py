"""The heights of the centre of mass at which the legs reach their footholds."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from wbc.errors import GaitError
from wbc.robot import Robot
from wbc.robot.posture import ankle_center, find_knee, knee_companions

_BEND = 0.6  # rad: a knee straighter than this has little grip on height and swing
_SHORTENING = 0.02  # m by which a knee, at least, brings the ankle nearer to the hip
_STRENGTH = 0.84  # share of the knee's torque limit that may go into carrying the robot
_ROLL_MARGIN = 0.08  # rad of the ankle's roll that is left to balance
_ROLLS = 0.5  # cosine of an axis to forward, from which on its joint rolls the foot
_TILT = 0.7  # share of the feet's extra distance by which the farther foot is off its hip
#: Share of a step that the rear foot is behind the hip when it leaves the ground, at usual speeds.
TRAIL = 0.7


class LegWorkspace:
    """Geometry of the legs: their knees, and hip to ankle distance with an almost straight knee.

    A rear foot that stays flat is left behind by about 0.7 of the step's length; with the
    hip's height z_h over the ankle and the leg's reach ρ, `z_h² + (0.7 L)² ≤ ρ²`.

    Args:
        robot: the robot.

    Raises:
        GaitError: a leg has no knee, or the robot has four legs.

    Attributes:
        knees: indices of both knees into (na,) vectors.
        reach: ρ, m.
        max_spread: largest distance of the feet beyond that in the nominal posture, m,
            before an ankle's roll joint is at its stop.
        max_step: longest step for which the knees can still carry the robot, m: a longer step
            lowers the hip, and a bent knee has the weight on a longer lever. Zero if they
            cannot carry it over the shortest one.
        min_knee_torque: what a knee needs for the shortest steps, N·m.
    """

    def __init__(self, robot: Robot) -> None:
        if robot.is_quadruped:
            raise GaitError(
                f"'{robot.name}' has four feet, and this is for robots on two; walk it with "
                "wbc.QuadrupedWalker, or state two of its feet (left_foot, right_foot)"
            )
        left, right = (_Leg(robot, side) for side in (0, 1))
        self.knees = (left.knee, right.knee)
        self.reach = min(left.reach, right.reach)
        self._hip_height = left.hip_height
        self._com_height = robot.com_height
        self.max_spread = min(left.roll, right.roll) * left.hip_height / _TILT
        drop = min(left.drop, right.drop)
        self.min_knee_torque = max(left.min_torque, right.min_torque)
        hip = max(left.hip_height - drop, 0.0)
        self.max_step = math.sqrt(max(self.reach**2 - hip**2, 0.0)) / TRAIL

    def com_height(self, step: float, trail: float = TRAIL) -> float:
        """Greatest height of the CoM that the legs allow, m; at most the nominal one.

        Args:
            step: length of the steps L, m.
            trail: share of L that the rear foot is behind the hip when it leaves the ground.
        """
        behind = min(trail * abs(step), 0.9 * self.reach)
        hip = math.sqrt(self.reach**2 - behind**2)
        return self._com_height + min(hip - self._hip_height, 0.0)


def _no_knee(robot: Robot, side: int) -> GaitError:
    sole, leg = robot.soles[side], robot.legs[side]
    joints = ", ".join(f"'{robot.joint_names[index - 6]}'" for index in leg)
    count = f"{len(leg)} joint{'s' if len(leg) > 1 else ''}"
    return GaitError(
        f"'{robot.name}' cannot walk: its {sole.side} leg has {count} ({joints}) between the base "
        f"and the foot '{sole.link}', and no knee that brings the foot nearer to the hip; "
        "name the feet below the knees (left_foot, right_foot), or fix fewer joints"
    )


class _Leg:
    """One leg's knee, reach and hip height over the ankle in the nominal posture."""

    def __init__(self, robot: Robot, side: int) -> None:
        model, q = robot.model, robot.q_nominal
        data = model.createData()
        sole, leg = robot.soles[side], robot.legs[side]
        joints = [j for j in range(1, model.njoints) if model.joints[j].idx_v in leg]
        knee = find_knee(model, q, sole.joint_id, sole.placement.translation, leg)
        if knee is None:
            raise _no_knee(robot, side)
        self.knee = knee - 6
        companions = knee_companions(model, q, knee, leg)
        ankle = joints[-1]
        # A leg that ends with its knee has no ankle: its sole is as good.
        ends_with_knee = model.joints[ankle].idx_v == knee
        below = sole.placement.translation if ends_with_knee else ankle_center(model, ankle)

        def span(configuration: np.ndarray) -> np.ndarray:
            """From the last ankle joint to the first hip joint, world axes."""
            pin.forwardKinematics(model, data, configuration)
            foot = data.oMi[ankle].act(below)
            return np.array(data.oMi[joints[0]].translation - foot)

        def length(angle: float) -> float:
            """From hip to ankle with the knee at an angle, m."""
            trial = q.copy()
            trial[knee + 1] = angle
            for other in companions:  # they share the bend of the knee
                trial[other + 1] = q[other + 1] + angle - q[knee + 1]
            return float(np.linalg.norm(span(trial)))

        self.roll = self._roll_range(robot, data, joints)
        lower = max(model.lowerPositionLimit[knee + 1], -3.0)
        upper = min(model.upperPositionLimit[knee + 1], 3.0)
        angles = np.linspace(lower, upper, 61)
        lengths = [length(angle) for angle in angles]
        longest = max(lengths)
        if longest - min(lengths) < _SHORTENING:
            raise _no_knee(robot, side)
        straight = float(angles[int(np.argmax(lengths))])
        bend = _BEND / (1 + len(companions))
        self.reach = length(straight + math.copysign(bend, q[knee + 1] - straight))
        self.hip_height = float(span(q)[2])
        self.drop = self._bearable_drop(robot, data, longest)

    def _roll_range(self, robot: Robot, data: pin.Data, joints: list[int]) -> float:
        """Play of the ankle's roll joint on its tighter side, less a margin, rad.

        Infinite without such a joint: the foot then rolls with the leg.
        """
        model, q = robot.model, robot.q_nominal
        pin.computeJointJacobians(model, data, q)
        along = []
        for joint in joints[-2:]:  # the ankle: the one of its joints whose axis points forward
            axis = pin.getJointJacobian(model, data, joint, pin.WORLD)[3:, model.idx_vs[joint]]
            along.append(abs(float(axis[0])))
        if max(along) < _ROLLS:
            return math.inf
        index = model.idx_vs[joints[-2:][int(np.argmax(along))]]
        angle = q[index + 1]
        play = min(
            model.upperPositionLimit[index + 1] - angle, angle - model.lowerPositionLimit[index + 1]
        )
        if play <= _ROLL_MARGIN:
            name = robot.joint_names[index - 6]
            raise GaitError(
                f"'{robot.name}' cannot walk: its ankle '{name}' is {play:.3f} rad from its limit "
                f"in the nominal posture, and to balance takes {_ROLL_MARGIN} rad to both sides; "
                "correct the joint's limits, or state a posture with this joint farther from them"
            )
        return float(play) - _ROLL_MARGIN

    def _bearable_drop(self, robot: Robot, data: pin.Data, longest: float) -> float:
        """By how much the hip may sink until the knee, alone, is at its strength's end, m.

        With thigh and shank of equal length l, the knee is √(l² − (d/2)²) off the line from hip
        to ankle at a distance d; the weight's lever grows in proportion.
        """
        model, q = robot.model, robot.q_nominal
        pin.forwardKinematics(model, data, q)
        knee = data.oMi[list(model.idx_vs).index(self.knee + 6)]
        lever = abs(float(knee.translation[0] - pin.centerOfMass(model, data, q)[0]))
        strength = _STRENGTH * float(robot.tau_max[self.knee]) / (robot.weight * max(lever, 1e-3))
        off = math.sqrt(max(longest**2 - self.hip_height**2, 0.0))  # twice the knee's offset
        shortest = math.sqrt(max(longest**2 - min(self.reach, self.hip_height) ** 2, 0.0))
        self.min_torque = shortest / max(off, 1e-6) * robot.weight * max(lever, 1e-3) / _STRENGTH
        bearable = min(off * strength, longest)
        return self.hip_height - math.sqrt(longest**2 - bearable**2)
