"""Whole-body inverse kinematics of standing postures: plans and checks, before anything moves."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.gait.leg_workspace import LegWorkspace
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.ik.posture_solver import PostureSolver, PostureTargets
from wbc.robot import Robot
from wbc.robot.upper_body import UpperBody

_HAND, _HEIGHT = 1e2, 1e2
_EXACT_HAND = 2e3  # once it is near
_COM, _FIRM = 1.0, 1e3
_TURN = 0.3  # of torso and base
_MARGIN = 0.03  # rad from the joints' limits
_SUPPORT = 0.35  # share of the soles over which the CoM may wander for a hand's sake
_NEAR = 1e-3  # m: a miss that is not worth another try
_REACHABLE = 0.02  # m: a miss that may come from the other wishes
_SAMPLES, _STARTS = 300, 4


class PostureIK:
    """Finds postures on both feet; see `PostureSolver`.

    Soles are where they are in the nominal posture; CoM, hands, and attitude of torso and base
    as wished. Head and fingers stay as they are, joints 0.03 rad within their limits.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.upper_body = UpperBody.of(robot)
        q = robot.q_nominal
        margin = np.minimum(_MARGIN, 0.25 * (robot.q_max - robot.q_min))
        # The nominal posture itself is always allowed.
        self._low = np.minimum(robot.q_min + margin, q[7:])
        self._high = np.maximum(robot.q_max - margin, q[7:])
        self._solver = PostureSolver(robot, self._low, self._high)
        self._model, self._data = robot.model, self._solver.data
        # Balance keeps the CoM over the middle of the soles, which is the origin, and as low as
        # knees that keep their grip have it.
        self._home = np.array([0.0, 0.0, LegWorkspace(robot).com_height(0.0)])
        self._upright = [np.array(self._data.oMf[f].rotation) for f in self._solver.trunk]
        moving = set(self.upper_body.waist) | {
            j for arm in self.upper_body.arms for j in arm.joints
        }
        moving |= {j - 6 for leg in robot.legs for j in leg}
        self._still = np.array([False] * 6 + [j not in moving for j in range(robot.na)])
        left, right = (at.translation for _, at in self._solver.soles)
        half = np.array([0.0, 0.5 * abs(left[1] - right[1])])
        half += [min(s.half_length for s in robot.soles), min(s.half_width for s in robot.soles)]
        self._com_box = _SUPPORT * half

    def place(self, frame: str, q: np.ndarray | None = None) -> np.ndarray:
        """(3,) where a frame is in a posture (nq,), by default the nominal one."""
        pin.forwardKinematics(self._model, self._data, self.robot.q_nominal if q is None else q)
        at = pin.updateFramePlacement(self._model, self._data, self.robot.frame_id(frame))
        return np.array(at.translation)

    def attitude(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Offset of the CoM, m, and rotation vectors of torso and pelvis, rad, (3,) each."""
        self._solver.forward(q)
        torso, pelvis = (
            np.asarray(pin.log3(self._data.oMf[f].rotation @ upright.T))
            for f, upright in zip(self._solver.trunk, self._upright, strict=True)
        )
        return np.array(self._data.com[0]) - self._home, torso, pelvis

    def on_soles(self, q: np.ndarray) -> tuple[np.ndarray, float, float]:
        """A posture with its left sole where it stands, and how far the right one is off.

        Returns:
            (nq,) the posture, distance in m and angle in rad of the right sole.
        """
        self._solver.forward(q)
        (left, at_left), (right, at_right) = self._solver.soles
        move = at_left * self._data.oMf[left].inverse()
        moved = q.copy()
        moved[:7] = pin.SE3ToXYZQUAT(move * pin.XYZQUATToSE3(q[:7]))
        off = at_right.inverse() * (move * self._data.oMf[right])
        miss = float(np.linalg.norm(off.translation))
        return moved, miss, float(np.linalg.norm(pin.log3(off.rotation)))

    def stops(self, pose: PostureSolution) -> str:
        """Names of the joints of legs and waist that are at their limit."""
        carrying = {j - 6 for leg in self.robot.legs for j in leg} | set(self.upper_body.waist)
        names = [f"'{self.robot.joint_names[k]}'" for k in pose.at_limit if k in carrying]
        return f"{' and '.join(names) or 'the legs'} at the limit"

    @cached_property
    def home(self) -> PostureSolution:
        """Standing as balance has it: trunk upright, CoM over the middle of the soles."""
        return self.find(PostureObjective(firm=True, firm_com=True))

    def find(
        self,
        objective: PostureObjective,
        start: np.ndarray | None = None,
        *,
        elsewhere: bool = True,
    ) -> PostureSolution:
        """The posture nearest to an objective.

        Args:
            objective: what it should be like.
            start: (nq,) to begin with; the nominal posture when left out.
            elsewhere: whether to try other ways to bend the arms when a hand misses.
        """
        pose = self._from(objective, self.robot.q_nominal if start is None else start)
        if elsewhere and pose.miss > _NEAR:
            others = [self._from(objective, q) for q in self._starts(objective)]
            pose = min([pose, *others], key=lambda p: p.miss)
        return pose

    def _from(self, objective: PostureObjective, start: np.ndarray) -> PostureSolution:
        pose = self._balanced(objective, start, _HAND)
        if 0.0 < pose.miss < _REACHABLE:
            pose = self._balanced(objective, pose.q, _EXACT_HAND)
        return pose

    def _starts(self, objective: PostureObjective) -> list[np.ndarray]:
        """Postures whose hands are near the wished places: other ways to bend the arms."""
        random = np.random.default_rng(0)
        starts = []
        arms = [arm for arm in self.upper_body.arms if arm.hand in objective.hands]
        joints = np.array([j for arm in arms for j in arm.joints], dtype=int)
        low, high = np.maximum(self._low, -3.0)[joints], np.minimum(self._high, 3.0)[joints]
        for _ in range(_SAMPLES):
            q = self.robot.q_nominal.copy()
            q[7 + joints] = random.uniform(low, high)
            pin.forwardKinematics(self._model, self._data, q)
            off = 0.0
            for arm in arms:
                frame = self.robot.frame_id(arm.hand)
                at = pin.updateFramePlacement(self._model, self._data, frame).translation
                off = max(off, float(np.linalg.norm(at - objective.hands[arm.hand])))
            starts.append((off, q))
        starts.sort(key=lambda one: one[0])
        return [q for _, q in starts[:_STARTS]]

    def _balanced(
        self, objective: PostureObjective, start: np.ndarray, hand: float
    ) -> PostureSolution:
        pose = self._solve(
            objective, start, objective.com, _FIRM if objective.firm_com else _COM, hand
        )
        if objective.firm_com:
            return pose
        away = np.clip(pose.com[:2], -self._com_box, self._com_box)
        if np.array_equal(away, pose.com[:2]):
            return pose
        return self._solve(objective, pose.q, np.array([*away, objective.com[2]]), _FIRM, hand)

    def _solve(
        self,
        objective: PostureObjective,
        start: np.ndarray,
        com: np.ndarray,
        com_weight: float,
        hand: float,
    ) -> PostureSolution:
        still = self._still.copy()
        still[[6 + joint for joint in objective.kept]] = True
        hands = [(self.robot.frame_id(name), place) for name, place in objective.hands.items()]
        torso, pelvis = (
            pin.exp3(turn) @ upright
            for turn, upright in zip(
                (objective.torso, objective.pelvis), self._upright, strict=True
            )
        )
        targets = PostureTargets(
            com=self._home + com,
            com_weight=np.array([com_weight, com_weight, max(com_weight, _HEIGHT)]),
            trunk=(torso, pelvis),
            turn=_FIRM if objective.firm else _TURN * objective.upright,
            hands=tuple(hands),
            hand=hand,
            near=self.robot.q_nominal if objective.near is None else objective.near,
        )
        q, held = self._solver.solve(start, still, targets)
        com, torso, pelvis = self.attitude(q)
        misses = {
            name: float(np.linalg.norm(place - self._data.oMf[frame].translation))
            for name, (frame, place) in zip(objective.hands, hands, strict=True)
        }
        com_miss = float(np.linalg.norm(com - objective.com))
        at_limit = tuple(int(k) - 6 for k in np.flatnonzero(held))
        return PostureSolution(q, com, torso, pelvis, misses, com_miss, at_limit)
