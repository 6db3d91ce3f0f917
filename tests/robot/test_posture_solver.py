"""The posture solver: its terms, its bounds, its minimum; and the statics of a posture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.robot.posture_solver import (
    ComTerm,
    JointTerm,
    NearPostureTerm,
    PoseTerm,
    PositionTerm,
    PostureSolver,
    RotationTerm,
)
from wbc.robot.statics import holding_torques, smallest_wrenches

ROBOT = wbc.load("simple_humanoid")
MODEL = ROBOT.model
LEFT = ROBOT.soles[0].frame_id
TORSO = ROBOT.frame_id(ROBOT.torso)


def solver(lower=None, upper=None) -> PostureSolver:
    return PostureSolver(
        MODEL,
        ROBOT.q_min if lower is None else lower,
        ROBOT.q_max if upper is None else upper,
        tolerance=1e-10,
    )


def near_nominal(scale: float, seed: int = 0) -> np.ndarray:
    random = np.random.default_rng(seed)
    return pin.integrate(MODEL, ROBOT.q_nominal, scale * random.uniform(-1.0, 1.0, ROBOT.nv))


TERMS = {
    "pose": PoseTerm(LEFT, pin.SE3(pin.utils.rotate("z", 0.01), np.array([0.0, 0.1, 0.0]))),
    "position": PositionTerm(TORSO, np.array([0.1, 0.0, 1.0])),
    "rotation": RotationTerm(TORSO, np.eye(3), axes=(0, 2)),
    "com": ComTerm(np.array([0.0, 0.0, 0.8])),
    "joint": JointTerm(8, 0.3),
    "posture": NearPostureTerm(ROBOT.q_nominal, 1.0),
}


@pytest.mark.parametrize("term", TERMS.values(), ids=TERMS)
def test_the_jacobian_of_a_term_predicts_how_its_error_changes(term):
    one, q = solver(), near_nominal(0.01)
    one.update(q)
    J, error = term.rows(MODEL, one.data, q)
    step = 1e-6 * np.random.default_rng(1).uniform(-1.0, 1.0, ROBOT.nv)
    moved = pin.integrate(MODEL, q, step)
    one.update(moved)
    # The difference of rotations makes it exact to first order of the error only.
    assert term.rows(MODEL, one.data, moved)[1] == pytest.approx(error - J @ step, abs=3e-8)


def test_a_posture_that_meets_all_terms_is_found():
    goal, one = near_nominal(0.1), solver(-np.full(ROBOT.na, 9.0), np.full(ROBOT.na, 9.0))
    one.update(goal)
    poses = [PoseTerm(s.frame_id, one.data.oMf[s.frame_id].copy()) for s in ROBOT.soles]
    com = ComTerm(np.array(one.data.com[0]))
    free = np.ones(ROBOT.nv, dtype=bool)
    q, held = one.solve(ROBOT.q_nominal, free, [*poses, com])
    assert not held.any()
    for term in (*poses, com):
        assert np.abs(term.rows(MODEL, one.data, q)[1]).max() < 1e-8


def test_a_joint_stops_at_its_bound_and_is_reported():
    joint = ROBOT.joint_index("left_elbow")
    upper = ROBOT.q_max.copy()
    upper[joint] = ROBOT.q_nominal[7 + joint] + 0.1
    free = np.zeros(ROBOT.nv, dtype=bool)
    free[6 + joint] = True
    q, held = solver(upper=upper).solve(ROBOT.q_nominal, free, [JointTerm(6 + joint, 2.0)])
    assert q[7 + joint] == upper[joint]
    assert np.flatnonzero(held).tolist() == [6 + joint]


def test_coordinates_that_are_not_free_do_not_move():
    free = np.zeros(ROBOT.nv, dtype=bool)
    free[list(ROBOT.legs[0])] = True
    q, _ = solver().solve(ROBOT.q_nominal, free, [ComTerm(np.array([0.1, 0.1, 0.5]))])
    moved = pin.difference(MODEL, ROBOT.q_nominal, q)
    assert np.abs(moved[free]).max() > 0.01
    assert np.abs(moved[~free]).max() < 1e-12


def test_the_smallest_wrenches_carry_the_weight_in_equal_parts():
    data = MODEL.createData()
    gravity = pin.computeGeneralizedGravity(MODEL, data, ROBOT.q_nominal)
    pin.computeJointJacobians(MODEL, data, ROBOT.q_nominal)
    J = np.vstack(
        [
            pin.computeFrameJacobian(MODEL, data, ROBOT.q_nominal, s.frame_id, pin.LOCAL)
            for s in ROBOT.soles
        ]
    )
    wrenches = smallest_wrenches(J, gravity[:6])
    assert J[:, :6].T @ wrenches == pytest.approx(gravity[:6], abs=1e-8)
    assert wrenches[2] == pytest.approx(wrenches[8], rel=0.05)
    assert wrenches[2] + wrenches[8] == pytest.approx(ROBOT.weight)
    torques = holding_torques(MODEL, ROBOT.q_nominal, [s.frame_id for s in ROBOT.soles])
    assert torques == pytest.approx(gravity[6:] - J[:, 6:].T @ wrenches)


def test_a_search_that_ends_without_progress_is_short_and_close_to_the_optimum():
    far = PositionTerm(TORSO, np.array([0.9, 0.4, 1.3]))  # the legs do not reach it
    soles = [PoseTerm(s.frame_id, pin.SE3.Identity(), 100.0) for s in ROBOT.soles]
    squares, evaluations = [], []
    for least_progress in (0.0, 1e-5):
        one = PostureSolver(MODEL, ROBOT.q_min, ROBOT.q_max, least_progress=least_progress)
        one.update(ROBOT.q_nominal)
        terms = [replace(t, target=one.data.oMf[t.frame].copy()) for t in soles]
        counting = _Counting(far)
        q, _ = one.solve(ROBOT.q_nominal, np.ones(ROBOT.nv, dtype=bool), [*terms, counting])
        errors = [(t.weight, t.rows(MODEL, one.data, q)[1]) for t in (*terms, far)]
        squares.append(sum(w * float(e @ e) for w, e in errors))
        evaluations.append(counting.evaluations)
    assert squares[1] == pytest.approx(squares[0], rel=1e-2)
    assert evaluations[1] < 0.7 * evaluations[0]


class _Counting:
    """A term that counts how often it is evaluated."""

    def __init__(self, term: PositionTerm) -> None:
        self._term, self.weight, self.evaluations = term, term.weight, 0

    def rows(
        self, model: pin.Model, data: pin.Data, q: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        self.evaluations += 1
        return self._term.rows(model, data, q)
