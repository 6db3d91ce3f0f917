"""The posture solver: its terms, its bounds, its minimum; and the statics of a posture."""

from __future__ import annotations

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
