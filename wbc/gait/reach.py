"""How high the centre of mass may be for the legs to reach their footholds."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from wbc.robot import Robot

_BEND = 0.6  # rad: a knee straighter than this has little grip on height and swing
_TRAIL = 0.7  # share of a step that the rear foot is behind the hip when it leaves the ground


class LegReach:
    """Geometry of the legs: their knees, and hip to ankle distance with an almost straight knee.

    A knee is the joint of its leg that changes the distance from hip to ankle most.

    A rear foot that stays flat is left behind by about 0.7 of the step's length; with the
    hip's height z_h over the ankle and the leg's reach ρ, `z_h² + (0.7 L)² ≤ ρ²`.

    Args:
        robot: the robot.

    Attributes:
        knees: indices of both knees into (na,) vectors.
        reach: ρ, m.
    """

    def __init__(self, robot: Robot) -> None:
        left, right = (_Leg(robot, side) for side in (0, 1))
        self.knees = (left.knee, right.knee)
        self.reach = min(left.reach, right.reach)
        self._hip_height = left.hip_height
        self._com_height = robot.com_height

    def com_height(self, step: float) -> float:
        """Greatest CoM height (m) for steps of length `step` (m), at most the nominal one."""
        trail = min(_TRAIL * abs(step), 0.9 * self.reach)
        hip = math.sqrt(self.reach**2 - trail**2)
        return self._com_height + min(hip - self._hip_height, 0.0)


class _Leg:
    """One leg's knee, reach and hip height over the ankle in the nominal posture."""

    def __init__(self, robot: Robot, side: int) -> None:
        model, q = robot.model, robot.q_nominal
        data = model.createData()
        leg = robot.legs[side]
        joints = [j for j in range(1, model.njoints) if model.joints[j].idx_v in leg]

        def span(configuration: np.ndarray) -> np.ndarray:
            """From the last ankle joint to the first hip joint, world axes."""
            pin.forwardKinematics(model, data, configuration)
            return np.array(data.oMi[joints[0]].translation - data.oMi[joints[-1]].translation)

        def bent(index: int, angle: float) -> np.ndarray:
            trial = q.copy()
            trial[index + 1] = angle
            return trial

        best = 0.0
        for index in leg[1:-1]:
            lower = max(model.lowerPositionLimit[index + 1], -3.0)
            upper = min(model.upperPositionLimit[index + 1], 3.0)
            angles = np.linspace(lower, upper, 61)
            spans = [float(np.linalg.norm(span(bent(index, a)))) for a in angles]
            if max(spans) - min(spans) > best:
                best = max(spans) - min(spans)
                straight = float(angles[int(np.argmax(spans))])
                self.knee = index - 6
        bend = math.copysign(_BEND, q[self.knee + 7] - straight)
        self.reach = float(np.linalg.norm(span(bent(self.knee + 6, straight + bend))))
        self.hip_height = float(span(q)[2])
