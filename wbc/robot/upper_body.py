"""Arms, head and waist of any robot, found in its kinematic tree without its names."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
import pinocchio as pin

from wbc.errors import MotionError
from wbc.robot import Robot

Side = Literal["left", "right"]
SIDES: tuple[Side, Side] = ("left", "right")

_ARM_JOINTS = 7  # further joints belong to a gripper
_ASIDE = 0.05  # share of the standing height; a limb farther than this from the middle is an arm
_WAIST = np.array([0.5, 0.5, 1.0])  # share of roll, pitch and yaw that the waist takes
_RANGE = 0.85  # share of the waist's range that may be used
_ALONG = 0.7  # an axis counts as pitch, roll or yaw when its cosine is larger


@dataclass(frozen=True)
class Arm:
    """An arm of a robot.

    Attributes:
        side: "left" or "right".
        joints: indices into (na,) vectors, from the trunk to the hand, fingers left out.
        shoulder: name of the joint that is highest among the first three.
        hand: name of the hand's frame: the link that moves with the last joint and is
            farthest from the joint before.
        length: length of the stretched arm from shoulder to hand, m.
    """

    side: Side
    joints: tuple[int, ...]
    shoulder: str
    hand: str
    length: float


@dataclass(frozen=True)
class Head:
    """A head that can be turned.

    Attributes:
        joints: indices into (na,) vectors, from the trunk on.
        frame: name of the last link.
    """

    joints: tuple[int, ...]
    frame: str


@dataclass(frozen=True)
class UpperBody:
    """Arms, head and waist of a robot.

    Attributes:
        robot: the robot.
        arms: the arms that it has, left before right.
        head: the head; None without one that can be turned.
        waist: indices into (na,) of the joints between base and torso.
        waist_range: (3, 2) least and greatest roll, pitch and yaw of the torso against the base
            that the waist's joints allow, rad.
    """

    robot: Robot
    arms: tuple[Arm, ...]
    head: Head | None
    waist: tuple[int, ...]
    waist_range: np.ndarray

    @classmethod
    def of(cls, robot: Robot) -> UpperBody:
        """Find the parts of a robot in its nominal posture."""
        model = robot.model
        data = model.createData()
        pin.computeJointJacobians(model, data, robot.q_nominal)
        pin.updateFramePlacements(model, data)
        trunk = int(model.frames[robot.frame_id(robot.torso)].parentJoint)
        legs = {index for leg in robot.legs for index in leg}
        aside = _ASIDE * robot.com_height
        arms: dict[Side, Arm] = {}
        head: Head | None = None
        for root in model.children[trunk]:
            if model.idx_vs[root] in legs:
                continue
            chain = _chain(model, int(root))
            tip = data.oMi[chain[-1]].translation
            if abs(tip[1]) > aside:
                side: Side = "left" if tip[1] > 0.0 else "right"
                arm = _arm(robot, data, side, chain[:_ARM_JOINTS])
                if side not in arms or len(arm.joints) > len(arms[side].joints):
                    arms[side] = arm
            elif tip[2] > data.oMi[trunk].translation[2]:
                head = Head(_indices(model, chain), _tip(robot, data, chain))
        waist = [int(j) for j in model.supports[trunk] if j > 1]
        return cls(
            robot,
            tuple(arms[s] for s in SIDES if s in arms),
            head,
            _indices(model, waist),
            _ranges(robot, data, waist),
        )

    def arm(self, side: str) -> Arm:
        """Return the arm of a side.

        Raises:
            MotionError: the robot has none.
        """
        for arm in self.arms:
            if arm.side == side:
                return arm
        have = ", ".join(arm.side for arm in self.arms) or "none"
        raise MotionError(f"{self.robot.name} has no {side} arm (it has: {have})")

    def both_arms(self) -> tuple[Arm, Arm]:
        """Return the left and the right arm.

        Raises:
            MotionError: one is missing.
        """
        return self.arm("left"), self.arm("right")

    def elbow(self, arm: Arm) -> int:
        """Return the joint, index into (na,), that changes the distance shoulder to hand most."""
        model, data = self.robot.model, self.robot.model.createData()
        shoulder = model.getJointId(arm.shoulder)
        hand = self.robot.frame_id(arm.hand)
        best, most = arm.joints[-1], 0.0
        for joint in arm.joints:
            reach = []
            for angle in np.linspace(self.robot.q_min[joint], self.robot.q_max[joint], 7):
                q = self.robot.q_nominal.copy()
                q[7 + joint] = angle
                pin.forwardKinematics(model, data, q)
                tip = pin.updateFramePlacement(model, data, hand).translation
                reach.append(float(np.linalg.norm(tip - data.oMi[shoulder].translation)))
            if max(reach) - min(reach) > most:
                best, most = joint, max(reach) - min(reach)
        return best

    def hips_share(self, turn: np.ndarray) -> np.ndarray:
        """Return the root link's share of a rotation of the upper trunk, rotation vectors, rad.

        The waist takes half of roll and pitch and all of the yaw, as far as its joints allow.

        Args:
            turn: (3,) rotation vector of the upper trunk, heading axes, rad.
        """
        low, high = _RANGE * self.waist_range.T
        return np.asarray(turn - np.clip(_WAIST * turn, low, high))


def _indices(model: pin.Model, joints: list[int]) -> tuple[int, ...]:
    return tuple(int(model.idx_vs[j]) - 6 for j in joints)


def _chain(model: pin.Model, root: int) -> list[int]:
    """Return the joints from a root until the limb branches (fingers) or ends."""
    chain = [root]
    while len(model.children[chain[-1]]) == 1:
        chain.append(int(model.children[chain[-1]][0]))
    return chain


def _tip(robot: Robot, data: pin.Data, chain: list[int]) -> str:
    """Return the link that moves with the last joint and is farthest from the joint before."""
    model = robot.model
    before = data.oMi[chain[-2] if len(chain) > 1 else chain[-1]].translation
    links = [
        frame
        for frame in range(model.nframes)
        if model.frames[frame].parentJoint == chain[-1] and model.frames[frame].type == pin.BODY
    ]
    far = max(links, key=lambda f: float(np.linalg.norm(data.oMf[f].translation - before)))
    return str(model.frames[far].name)


def _arm(robot: Robot, data: pin.Data, side: Side, chain: list[int]) -> Arm:
    model = robot.model
    shoulder = max(chain[:3], key=lambda j: float(data.oMi[j].translation[2]))
    hand = _tip(robot, data, chain)
    way = [data.oMi[j].translation for j in chain[chain.index(shoulder) :]]
    way.append(data.oMf[robot.frame_id(hand)].translation)
    length = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(way))
    return Arm(side, _indices(model, chain), str(model.names[shoulder]), hand, length)


def _ranges(robot: Robot, data: pin.Data, waist: list[int]) -> np.ndarray:
    ranges = np.zeros((3, 2))
    for joint in waist:
        index = robot.model.idx_vs[joint]
        along = data.J[3:, index]
        axis = int(np.argmax(np.abs(along)))
        if abs(along[axis]) < _ALONG:
            continue
        now = robot.q_nominal[index + 1]
        ends = [robot.q_min[index - 6] - now, robot.q_max[index - 6] - now]
        ranges[axis] = ends if along[axis] > 0.0 else [-ends[1], -ends[0]]
    return ranges
