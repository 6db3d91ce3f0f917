"""Inverse kinematics of a whole body in bounds, as nonlinear least squares."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.robot import Robot

_SOLE = 1e4
_LEGS, _REST = 1e-3, 1e-2  # of the posture
_DAMPING = 1e-6
_STUCK = 1e6
_ITERATIONS = 120
_WORLD = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED


@dataclass(frozen=True)
class PostureTargets:
    """Targets and weights of one solution, world axes.

    Attributes:
        com: (3,) m.
        com_weight: (3,).
        trunk: (3, 3) wished rotations of torso and base.
        turn: weight of those.
        hands: frame id and (3,) place, m.
        hand: weight of those.
        near: (nq,) posture that what is left open goes to.
    """

    com: np.ndarray
    com_weight: np.ndarray
    trunk: tuple[np.ndarray, np.ndarray]
    turn: float
    hands: tuple[tuple[int, np.ndarray], ...]
    hand: float
    near: np.ndarray


class PostureSolver:
    """Levenberg and Marquardt's method on weighted squares, with joints held at their bounds.

        min ½ Σ wᵢ |eᵢ(q)|² + ½ |q ⊖ q_near|²_W,   low ≤ q_joints ≤ high

    over the errors of soles, CoM, hands, and attitude of torso and base (Marquardt, An
    algorithm for least-squares estimation of nonlinear parameters, 1963). A joint stays at its
    bound as long as the step pushes against it.

    Args:
        robot: the robot; its soles stay where they are in the nominal posture.
        low: (na,) rad.
        high: (na,) rad.
    """

    def __init__(self, robot: Robot, low: np.ndarray, high: np.ndarray) -> None:
        self._model, self.data = robot.model, robot.model.createData()
        self._low, self._high = low, high
        self.forward(robot.q_nominal)
        self.soles = [(s.frame_id, self.data.oMf[s.frame_id].copy()) for s in robot.soles]
        self.trunk = [robot.frame_id(name) for name in (robot.torso, robot.base)]
        self._posture = np.full(robot.nv, _REST)
        self._posture[:6] = 0.0
        for leg in robot.legs:
            self._posture[list(leg)] = _LEGS

    def forward(self, q: np.ndarray) -> None:
        """Frames, CoM and their Jacobians of a posture (nq,), into `data`."""
        pin.computeJointJacobians(self._model, self.data, q)
        pin.updateFramePlacements(self._model, self.data)
        pin.jacobianCenterOfMass(self._model, self.data, q)

    def solve(
        self, start: np.ndarray, still: np.ndarray, targets: PostureTargets
    ) -> tuple[np.ndarray, np.ndarray]:
        """The posture that comes nearest to the targets, from a start.

        Args:
            start: (nq,).
            still: (nv,) which coordinates do not move.
            targets: what it should be like.

        Returns:
            (nq,) the posture, and (nv,) which coordinates are held at a bound.
        """
        q, free = start.copy(), ~still[6:]
        self._keep_within(q, free)
        cost, H, g = self._normal(q, targets)
        damping = _DAMPING
        held = np.zeros_like(still)
        for _ in range(_ITERATIONS):
            step, held = self._step(q, H + damping * np.eye(g.size), g, still)
            trial = pin.integrate(self._model, q, step)
            self._keep_within(trial, free)
            new_cost, new_H, new_g = self._normal(trial, targets)
            if new_cost > cost:
                damping *= 10.0
                if damping > _STUCK:
                    break
                continue
            q, cost, H, g = trial, new_cost, new_H, new_g
            damping = max(damping * 0.2, _DAMPING)
            if float(np.abs(step).max()) < 1e-7:
                break
        self.forward(q)
        return q, held & ~still

    def _keep_within(self, q: np.ndarray, free: np.ndarray) -> None:
        q[7:][free] = np.clip(q[7:], self._low, self._high)[free]

    def _normal(
        self, q: np.ndarray, targets: PostureTargets
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Half the squares' sum at q, and Hessian and gradient of the step of its model."""
        model, data = self._model, self.data
        self.forward(q)
        rows: list[np.ndarray] = []
        errors: list[np.ndarray] = []
        weights: list[np.ndarray] = []

        def add(J: np.ndarray, e: np.ndarray, weight: float | np.ndarray) -> None:
            rows.append(J)
            errors.append(e)
            weights.append(np.broadcast_to(weight, e.shape))

        for frame, at in self.soles:
            J = pin.getFrameJacobian(model, data, frame, _WORLD)
            now = data.oMf[frame]
            turned = pin.log3(at.rotation @ now.rotation.T)
            add(J, np.concatenate((at.translation - now.translation, turned)), _SOLE)
        add(data.Jcom, targets.com - data.com[0], targets.com_weight)
        for frame, rotation in zip(self.trunk, targets.trunk, strict=True):
            J = pin.getFrameJacobian(model, data, frame, _WORLD)[3:]
            add(J, pin.log3(rotation @ data.oMf[frame].rotation.T), targets.turn)
        for frame, place in targets.hands:
            J = pin.getFrameJacobian(model, data, frame, _WORLD)[:3]
            add(J, place - data.oMf[frame].translation, targets.hand)
        J, e, w = np.vstack(rows), np.concatenate(errors), np.concatenate(weights)
        off = pin.difference(model, q, targets.near)
        pull = self._posture * off
        H = np.diag(self._posture) + (J.T * w) @ J
        return 0.5 * float(e @ (w * e) + off @ pull), H, pull + J.T @ (w * e)

    def _step(
        self, q: np.ndarray, H: np.ndarray, g: np.ndarray, still: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """The step with joints held that would leave their range, and which those are."""
        held = still.copy()
        while True:
            free = ~held
            step = np.zeros(g.size)
            step[free] = np.linalg.solve(H[np.ix_(free, free)], g[free])
            after = q[7:] + step[6:]
            beyond = ((q[7:] <= self._low + 1e-9) & (after < self._low)) | (
                (q[7:] >= self._high - 1e-9) & (after > self._high)
            )
            new = np.concatenate((np.zeros(6, dtype=bool), beyond)) & free
            if not new.any():
                return step, held
            held |= new
