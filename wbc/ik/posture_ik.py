"""Inverse kinematics of standing postures: for plans and checks, before anything moves."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.gait.leg_workspace import LegWorkspace
from wbc.ik.objective import PostureObjective, PostureSolution
from wbc.robot import Robot, checked_robot
from wbc.robot.posture_solver import (
    ComTerm,
    NearPostureTerm,
    PoseTerm,
    PositionTerm,
    PostureSolver,
    PostureTerm,
    RotationTerm,
)
from wbc.robot.self_collision import SelfCollision
from wbc.robot.upper_body import UpperBody

# Weights of squared errors, 1/m² and 1/rad².
_SOLE = 1e4
_HAND, _HEIGHT = 1e2, 1e2
_EXACT_HAND = 2e3  # once it is near
_COM, _STRICT = 1.0, 1e3
_TRUNK = 0.3
_NEAR_LEGS, _NEAR_OTHERS = 1e-3, 1e-2
_MARGIN = 0.03  # rad from the joints' limits
_SUPPORT = 0.35  # share of the soles over which the CoM may move for a hand's sake
_NEGLIGIBLE = 1e-3  # m: a hand error that is not worth another try
_REFINABLE = 0.02  # m: a hand error that may come from the other targets
_SAMPLES, _STARTS = 300, 4
_LEAST_PROGRESS = 1e-5  # share of the squares: hundreds of steps can end a search out of reach
_CLEARANCE = 5e-3  # m between the robot's own bodies


class PostureIK:
    """Finds postures on both feet with the `PostureSolver`.

    Soles stay where they are in the nominal posture; CoM, hands, and rotation of torso and base
    follow the objective. Head and fingers stay as they are, joints 0.03 rad within their limits.

    What it finds are compromises, whose squares are not zero at their least sum.
    `InverseKinematics.reach` searches for postures at which targets vanish, and ends an attempt
    that hardly comes nearer: on 200 objectives of five robots, a quarter of them out of reach, the
    squares that it left were 1.0 to 1.3 times these (median per robot), with the soles up to 30 mm
    off. Where it goes on until it converges the optima are the same.

    Args:
        robot: the robot.

    Attributes:
        robot: the robot.
        upper_body: its arms, head and waist.

    Raises:
        GaitError: a leg has no knee.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = checked_robot(robot, "PostureIK")
        self.upper_body = UpperBody.of(robot)
        q = robot.q_nominal
        margin = np.minimum(_MARGIN, 0.25 * (robot.q_max - robot.q_min))
        # The nominal posture itself is always allowed.
        self._low = np.minimum(robot.q_min + margin, q[7:])
        self._high = np.maximum(robot.q_max - margin, q[7:])
        self._solver = PostureSolver(
            robot.model, self._low, self._high, least_progress=_LEAST_PROGRESS
        )
        self._model, self._data = robot.model, self._solver.data
        self._solver.update(q)
        self._soles = tuple(
            PoseTerm(sole.frame_id, self._data.oMf[sole.frame_id].copy(), _SOLE)
            for sole in robot.soles
        )
        self._trunk = [robot.frame_id(name) for name in (robot.torso, robot.base)]
        self._upright = [np.array(self._data.oMf[f].rotation) for f in self._trunk]
        # Balance keeps the CoM over the middle of the soles, which is the origin, and low enough
        # for the knees to keep their grip.
        self._com_home = np.array([0.0, 0.0, LegWorkspace(robot).com_height(0.0)])
        legs = [index for leg in robot.legs for index in leg]
        arms = [6 + joint for arm in self.upper_body.arms for joint in arm.joints]
        self._free = np.zeros(robot.nv, dtype=bool)
        self._free[[*range(6), *legs, *arms, *(6 + joint for joint in self.upper_body.waist)]] = (
            True
        )
        self._near_weight = np.full(robot.nv, _NEAR_OTHERS)
        self._near_weight[:6] = 0.0
        self._near_weight[legs] = _NEAR_LEGS
        left, right = (term.target.translation for term in self._soles)
        half = np.array([0.0, 0.5 * abs(left[1] - right[1])])
        half += [min(s.half_length for s in robot.soles), min(s.half_width for s in robot.soles)]
        self._com_bound = _SUPPORT * half

    def frame_position(self, frame: str, q: np.ndarray | None = None) -> np.ndarray:
        """Return where a frame is in a posture (nq,), by default the nominal one; (3,) m."""
        pin.forwardKinematics(self._model, self._data, self.robot.q_nominal if q is None else q)
        at = pin.updateFramePlacement(self._model, self._data, self.robot.frame_id(frame))
        return np.array(at.translation)

    def com_and_trunk(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the CoM's offset, m, and the rotation vectors of torso and pelvis, rad; (3,)."""
        self._solver.update(q)
        torso, pelvis = (
            np.asarray(pin.log3(self._data.oMf[f].rotation @ upright.T))
            for f, upright in zip(self._trunk, self._upright, strict=True)
        )
        return np.array(self._data.com[0]) - self._com_home, torso, pelvis

    def place_on_left_sole(self, q: np.ndarray) -> tuple[np.ndarray, float, float]:
        """Move a posture rigidly such that its left sole is where it stands.

        Returns:
            (nq,) the posture; distance (m) and angle (rad) of the right sole from where it stands.
        """
        self._solver.update(q)
        left, right = self._soles
        move = left.target * self._data.oMf[left.frame].inverse()
        moved = q.copy()
        moved[:7] = pin.SE3ToXYZQUAT(move * pin.XYZQUATToSE3(q[:7]))
        off = right.target.inverse() * (move * self._data.oMf[right.frame])
        distance = float(np.linalg.norm(off.translation))
        return moved, distance, float(np.linalg.norm(pin.log3(off.rotation)))

    def limiting_joints(self, posture: PostureSolution) -> str:
        """Return the names of the joints of legs and waist at their limit, as a phrase."""
        legs = {j - 6 for leg in self.robot.legs for j in leg}
        carrying = legs | set(self.upper_body.waist)
        names = [f"'{self.robot.joint_names[k]}'" for k in posture.at_limit if k in carrying]
        return f"{' and '.join(names) or 'the legs'} at the limit"

    def limits_of_reach(self, posture: PostureSolution) -> str:
        """Return what keeps the hands from their targets: joints at their limit, as a phrase."""
        idle = [arm for arm in self.upper_body.arms if arm.hand not in posture.hand_errors]
        others = {joint for arm in idle for joint in arm.joints}
        names = [f"'{self.robot.joint_names[k]}'" for k in posture.at_limit if k not in others]
        return f"{' and '.join(names)} at the limit" if names else "the arm is stretched"

    def self_contact(self, q: np.ndarray) -> str:
        """Return the names of two bodies of the robot that touch in a posture (nq,), or nearly.

        Empty when all are at least 5 mm apart.
        """
        return SelfCollision.of(self.robot).first_contact(q, _CLEARANCE)

    @cached_property
    def standing(self) -> PostureSolution:
        """Standing as the balance keeps it: trunk upright, CoM over the middle of the soles."""
        return self.solve(PostureObjective(strict_trunk=True, strict_com=True))

    def solve(
        self,
        objective: PostureObjective,
        start: np.ndarray | None = None,
        *,
        restarts: int = _STARTS,
    ) -> PostureSolution:
        """Return the posture that comes nearest to an objective.

        Args:
            objective: targets of the posture.
            start: (nq,) posture to begin with; the nominal one when left out.
            restarts: how many other ways to bend the arms are tried when a hand misses its
                target.
        """
        best = self._refined(objective, self.robot.q_nominal if start is None else start)
        if restarts and best.hand_error > _NEGLIGIBLE:
            others = [self._refined(objective, q) for q in self._starts(objective)[:restarts]]
            best = min([best, *others], key=lambda solution: solution.hand_error)
        return best

    def _refined(self, objective: PostureObjective, start: np.ndarray) -> PostureSolution:
        solution = self._balanced(objective, start, _HAND)
        if 0.0 < solution.hand_error < _REFINABLE:
            solution = self._balanced(objective, solution.q, _EXACT_HAND)
        return solution

    def _starts(self, objective: PostureObjective) -> list[np.ndarray]:
        """Return random postures by the hands' distance to their targets, the nearest first."""
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
        return [q for _, q in starts]

    def _balanced(
        self, objective: PostureObjective, start: np.ndarray, hand_weight: float
    ) -> PostureSolution:
        """Return a posture whose CoM stays within its bound over the soles."""
        com_weight = _STRICT if objective.strict_com else _COM
        solution = self._solve(objective, start, objective.com, com_weight, hand_weight)
        if objective.strict_com:
            return solution
        bounded = np.clip(solution.com[:2], -self._com_bound, self._com_bound)
        if np.array_equal(bounded, solution.com[:2]):
            return solution
        com = np.array([*bounded, objective.com[2]])
        return self._solve(objective, solution.q, com, _STRICT, hand_weight)

    def _solve(
        self,
        objective: PostureObjective,
        start: np.ndarray,
        com: np.ndarray,
        com_weight: float,
        hand_weight: float,
    ) -> PostureSolution:
        free = self._free.copy()
        free[[6 + joint for joint in objective.fixed_joints]] = False
        trunk_weight = _STRICT if objective.strict_trunk else _TRUNK * objective.trunk_weight
        terms: list[PostureTerm] = [*self._soles]
        weights = np.array([com_weight, com_weight, max(com_weight, _HEIGHT)])
        terms.append(ComTerm(self._com_home + com, weights))
        for frame, turn, upright in zip(
            self._trunk, (objective.torso, objective.pelvis), self._upright, strict=True
        ):
            terms.append(RotationTerm(frame, pin.exp3(turn) @ upright, trunk_weight))
        frames = {name: self.robot.frame_id(name) for name in objective.hands}
        for name, place in objective.hands.items():
            terms.append(PositionTerm(frames[name], place, hand_weight))
        near = self.robot.q_nominal if objective.near is None else objective.near
        terms.append(NearPostureTerm(near, self._near_weight))
        q, held = self._solver.solve(start, free, terms)
        reached, torso, pelvis = self.com_and_trunk(q)
        errors = {
            name: float(np.linalg.norm(place - self._data.oMf[frames[name]].translation))
            for name, place in objective.hands.items()
        }
        com_error = float(np.linalg.norm(reached - objective.com))
        at_limit = tuple(int(k) - 6 for k in np.flatnonzero(held))
        return PostureSolution(q, reached, torso, pelvis, errors, com_error, at_limit)
