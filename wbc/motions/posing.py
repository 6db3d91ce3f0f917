"""Whole-body inverse kinematics of standing postures: plans and checks, before anything moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import pinocchio as pin

from wbc.gait.reach import LegReach
from wbc.motions.anatomy import Anatomy
from wbc.robot import Robot

_SOLE, _HAND, _HEIGHT = 1e4, 1e2, 1e2
_EXACT_HAND = 2e3  # once it is near
_COM, _FAR_COM = 1.0, 1e3
_TURN = 0.3  # of torso and base
_LEGS, _REST = 1e-3, 1e-2  # of the posture
_MARGIN = 0.03  # rad from the joints' limits
_DAMPING = 1e-6
_STUCK = 1e6
_ITERATIONS = 120
_SUPPORT = 0.35  # share of the soles over which the CoM may wander for a hand's sake
_NEAR = 1e-3  # m: a miss that is not worth another try
_REACHABLE = 0.02  # m: a miss that may come from the other wishes
_SAMPLES, _STARTS = 300, 4
_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


def _zeros() -> np.ndarray:
    return np.zeros(3)


@dataclass(frozen=True)
class Wish:
    """What a posture should be like; in the standing frame.

    Attributes:
        com: (3,) offset of the CoM from standing, m.
        torso: (3,) rotation vector of the upper trunk, rad.
        pelvis: (3,) likewise of the root link.
        hands: frame -> (3,) place of its origin, m.
        firm: whether the trunk is to be as said, instead of helping the hands.
        firm_com: likewise the CoM.
        upright: how dear it is to turn the trunk for a hand's sake; 1 is cheap.
        kept: indices into (na,) of joints that stay as they are at the start.
    """

    com: np.ndarray = field(default_factory=_zeros)
    torso: np.ndarray = field(default_factory=_zeros)
    pelvis: np.ndarray = field(default_factory=_zeros)
    hands: Mapping[str, np.ndarray] = field(default_factory=dict)
    firm: bool = False
    firm_com: bool = False
    upright: float = 1.0
    kept: tuple[int, ...] = ()


@dataclass(frozen=True)
class Pose:
    """A posture that was found.

    Attributes:
        q: (nq,) in the standing frame.
        com: (3,) offset of the CoM from standing, m.
        torso: (3,) rotation vector of the upper trunk, rad.
        pelvis: (3,) of the root link.
        misses: frame -> distance to its wished place, m.
        com_miss: distance of the CoM to its wished place, m.
        at_limit: indices into (na,) of joints at their limit.
    """

    q: np.ndarray
    com: np.ndarray
    torso: np.ndarray
    pelvis: np.ndarray
    misses: Mapping[str, float]
    com_miss: float
    at_limit: tuple[int, ...]


@dataclass(frozen=True)
class _Aims:
    """Targets and weights of one solution, world axes."""

    com: np.ndarray
    com_weight: np.ndarray
    trunk: tuple[np.ndarray, np.ndarray]
    turn: float
    hands: tuple[tuple[int, np.ndarray], ...]
    hand: float


class Posing:
    """Finds postures on both feet.

    Levenberg and Marquardt's method on the weighted squares of: soles where they are in the
    nominal posture, CoM, hands, attitude of torso and base, and little of the posture. Joints
    are held at their limits (less 0.03 rad) as long as they push against them; head and fingers
    stay as they are.

    Args:
        robot: the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        model = self._model = robot.model
        self._data = model.createData()
        q = robot.q_nominal
        self.anatomy = Anatomy.of(robot)
        self._forward(q)
        # Balance keeps the CoM over the middle of the soles, which is the origin, and as low as
        # knees that keep their grip have it.
        self._home = np.array([0.0, 0.0, LegReach(robot).com_height(0.0)])
        self._soles = [(s.frame_id, self._data.oMf[s.frame_id].copy()) for s in robot.soles]
        self._trunk = [robot.frame_id(name) for name in (robot.torso, robot.base)]
        self._upright = [np.array(self._data.oMf[f].rotation) for f in self._trunk]
        weights = np.full(robot.nv, _REST)
        weights[:6] = 0.0
        for leg in robot.legs:
            weights[list(leg)] = _LEGS
        self._posture = weights
        moving = set(self.anatomy.waist) | {j for arm in self.anatomy.arms for j in arm.joints}
        moving |= {j - 6 for leg in robot.legs for j in leg}
        self._still = np.array([False] * 6 + [j not in moving for j in range(robot.na)])
        margin = np.minimum(_MARGIN, 0.25 * (robot.q_max - robot.q_min))
        # The nominal posture itself is always allowed.
        self._low = np.minimum(robot.q_min + margin, q[7:])
        self._high = np.maximum(robot.q_max - margin, q[7:])
        half = min(s.half_length for s in robot.soles)
        spread = 0.5 * abs(self._soles[0][1].translation[1] - self._soles[1][1].translation[1])
        self._com_box = _SUPPORT * np.array([half, spread + min(s.half_width for s in robot.soles)])

    def place(self, frame: str, q: np.ndarray | None = None) -> np.ndarray:
        """(3,) where a frame is in a posture (nq,), by default the nominal one."""
        pin.forwardKinematics(self._model, self._data, self.robot.q_nominal if q is None else q)
        at = pin.updateFramePlacement(self._model, self._data, self.robot.frame_id(frame))
        return np.array(at.translation)

    def attitude(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Offset of the CoM, m, and rotation vectors of torso and pelvis, rad, (3,) each."""
        self._forward(q)
        torso, pelvis = (
            np.asarray(pin.log3(self._data.oMf[f].rotation @ upright.T))
            for f, upright in zip(self._trunk, self._upright, strict=True)
        )
        return np.array(self._data.com[0]) - self._home, torso, pelvis

    def on_soles(self, q: np.ndarray) -> tuple[np.ndarray, float, float]:
        """A posture with its left sole where it stands, and how far the right one is off.

        Returns:
            (nq,) the posture, distance in m and angle in rad of the right sole.
        """
        self._forward(q)
        (left, at_left), (right, at_right) = self._soles
        move = at_left * self._data.oMf[left].inverse()
        moved = q.copy()
        moved[:7] = pin.SE3ToXYZQUAT(move * pin.XYZQUATToSE3(q[:7]))
        off = at_right.inverse() * (move * self._data.oMf[right])
        miss = float(np.linalg.norm(off.translation))
        return moved, miss, float(np.linalg.norm(pin.log3(off.rotation)))

    @cached_property
    def home(self) -> Pose:
        """Standing as balance has it: trunk upright, CoM over the middle of the soles."""
        return self.find(Wish(firm=True, firm_com=True))

    def find(self, wish: Wish, start: np.ndarray | None = None, *, elsewhere: bool = True) -> Pose:
        """The posture nearest to a wish.

        Args:
            wish: what it should be like.
            start: (nq,) to begin with; the nominal posture when left out.
            elsewhere: whether to try other ways to bend the arms when a hand misses.
        """
        pose = self._from(wish, start)
        if elsewhere and max(pose.misses.values(), default=0.0) > _NEAR:
            others = [self._from(wish, q) for q in self._starts(wish)]
            pose = min([pose, *others], key=lambda p: max(p.misses.values()))
        return pose

    def _from(self, wish: Wish, start: np.ndarray | None) -> Pose:
        pose = self._balanced(wish, start, _HAND)
        if 0.0 < max(pose.misses.values(), default=0.0) < _REACHABLE:
            pose = self._balanced(wish, pose.q, _EXACT_HAND)
        return pose

    def _starts(self, wish: Wish) -> list[np.ndarray]:
        """Postures whose hands are near the wished places: other ways to bend the arms."""
        random = np.random.default_rng(0)
        starts = []
        arms = [arm for arm in self.anatomy.arms if arm.hand in wish.hands]
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
                off = max(off, float(np.linalg.norm(at - wish.hands[arm.hand])))
            starts.append((off, q))
        starts.sort(key=lambda one: one[0])
        return [q for _, q in starts[:_STARTS]]

    def _balanced(self, wish: Wish, start: np.ndarray | None, hand: float) -> Pose:
        pose = self._solve(wish, start, wish.com, _FAR_COM if wish.firm_com else _COM, hand)
        if wish.firm_com:
            return pose
        away = np.clip(pose.com[:2], -self._com_box, self._com_box)
        if np.array_equal(away, pose.com[:2]):
            return pose
        return self._solve(wish, pose.q, np.array([*away, wish.com[2]]), _FAR_COM, hand)

    def _forward(self, q: np.ndarray) -> None:
        model, data = self._model, self._data
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        pin.jacobianCenterOfMass(model, data, q)

    def _solve(
        self,
        wish: Wish,
        start: np.ndarray | None,
        com: np.ndarray,
        com_weight: float,
        hand: float,
    ) -> Pose:
        robot, model = self.robot, self._model
        q = np.array(robot.q_nominal if start is None else start)
        still = self._still.copy()
        still[[6 + joint for joint in wish.kept]] = True
        free = ~still[6:]
        q[7:][free] = np.clip(q[7:], self._low, self._high)[free]
        hands = [(robot.frame_id(name), place) for name, place in wish.hands.items()]
        aims = _Aims(
            self._home + com,
            np.array([com_weight, com_weight, max(com_weight, _HEIGHT)]),
            (wish.torso, wish.pelvis),
            _FAR_COM if wish.firm else _TURN * wish.upright,
            tuple(hands),
            hand,
        )
        cost, H, g = self._normal(q, aims)
        damping = _DAMPING
        held = np.zeros(robot.nv, dtype=bool)
        for _ in range(_ITERATIONS):
            step, held = self._step(q, H + damping * np.eye(robot.nv), g, still)
            trial = pin.integrate(model, q, step)
            trial[7:][free] = np.clip(trial[7:], self._low, self._high)[free]
            new_cost, new_H, new_g = self._normal(trial, aims)
            if new_cost > cost:
                damping *= 10.0
                if damping > _STUCK:
                    break
                continue
            q, cost, H, g = trial, new_cost, new_H, new_g
            damping = max(damping * 0.2, _DAMPING)
            if float(np.abs(step).max()) < 1e-7:
                break
        self._forward(q)
        return self._pose(q, wish, hands, held & ~still)

    def _normal(self, q: np.ndarray, aims: _Aims) -> tuple[float, np.ndarray, np.ndarray]:
        """Half the squares' sum at q, and Hessian and gradient of the step of its model."""
        model, data = self._model, self._data
        self._forward(q)
        rows: list[np.ndarray] = []
        errors: list[np.ndarray] = []
        weights: list[np.ndarray] = []

        def add(J: np.ndarray, e: np.ndarray, weight: float | np.ndarray) -> None:
            rows.append(J)
            errors.append(e)
            weights.append(np.broadcast_to(weight, e.shape))

        for frame, at in self._soles:
            J = pin.getFrameJacobian(model, data, frame, _WORLD)
            now = data.oMf[frame]
            turned = pin.log3(at.rotation @ now.rotation.T)
            add(J, np.concatenate((at.translation - now.translation, turned)), _SOLE)
        add(data.Jcom, aims.com - data.com[0], aims.com_weight)
        for frame, upright, wanted in zip(self._trunk, self._upright, aims.trunk, strict=True):
            J = pin.getFrameJacobian(model, data, frame, _WORLD)[3:]
            rotation = pin.exp3(wanted) @ upright
            add(J, pin.log3(rotation @ data.oMf[frame].rotation.T), aims.turn)
        for frame, place in aims.hands:
            J = pin.getFrameJacobian(model, data, frame, _WORLD)[:3]
            add(J, place - data.oMf[frame].translation, aims.hand)
        J, e, w = np.vstack(rows), np.concatenate(errors), np.concatenate(weights)
        off = pin.difference(model, q, self.robot.q_nominal)
        pull = self._posture * off
        H = np.diag(self._posture) + (J.T * w) @ J
        return 0.5 * float(e @ (w * e) + off @ pull), H, pull + J.T @ (w * e)

    def _step(
        self, q: np.ndarray, H: np.ndarray, g: np.ndarray, still: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The step with joints held that would leave their range, and which those are."""
        nv = g.size
        held = still.copy()
        while True:
            free = ~held
            step = np.zeros(nv)
            step[free] = np.linalg.solve(H[np.ix_(free, free)], g[free])
            after = q[7:] + step[6:]
            beyond = ((q[7:] <= self._low + 1e-9) & (after < self._low)) | (
                (q[7:] >= self._high - 1e-9) & (after > self._high)
            )
            new = np.concatenate((np.zeros(6, dtype=bool), beyond)) & free
            if not new.any():
                return step, held
            held |= new

    def _pose(
        self, q: np.ndarray, wish: Wish, hands: list[tuple[int, np.ndarray]], fixed: np.ndarray
    ) -> Pose:
        com, torso, pelvis = self.attitude(q)
        data = self._data
        misses = {
            name: float(np.linalg.norm(place - data.oMf[frame].translation))
            for name, (frame, place) in zip(wish.hands, hands, strict=True)
        }
        at_limit = tuple(int(k) - 6 for k in np.flatnonzero(fixed))
        return Pose(q, com, torso, pelvis, misses, float(np.linalg.norm(com - wish.com)), at_limit)
