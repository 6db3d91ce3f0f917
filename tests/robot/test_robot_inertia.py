"""Inertias: which ones a rigid body can have, and the repair of those it cannot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robottools import FEET, changed, inertial

import wbc.robot
from wbc.robot.inertia import MIN_GYRATION, is_physical, physical_inertia

moment = st.floats(-1.0, 2.0)
angle = st.floats(-3.0, 3.0)


def turned(moments, angles):
    R = pin.rpy.rpyToMatrix(*angles)
    return R @ np.diag(moments) @ R.T


@given(st.lists(st.tuples(*[st.floats(-1, 1)] * 3), min_size=4, max_size=12))
@settings(max_examples=60)
def test_the_inertia_of_points_is_physical_and_repair_leaves_it(points):
    points = np.array(points) * 0.3
    points -= points.mean(axis=0)
    inertia = sum(float(p @ p) * np.eye(3) - np.outer(p, p) for p in points) / len(points)
    if np.linalg.eigvalsh(0.5 * np.trace(inertia) * np.eye(3) - inertia)[0] > MIN_GYRATION**2:
        assert is_physical(1.0, inertia)
        np.testing.assert_allclose(physical_inertia(1.0, inertia), inertia, atol=1e-12)


@given(st.tuples(moment, moment, moment), st.tuples(angle, angle, angle), st.floats(0.01, 20))
@settings(max_examples=60)
def test_repair_makes_any_inertia_physical(moments, angles, mass):
    inertia = physical_inertia(mass, turned(moments, angles))
    assert is_physical(mass, inertia, 1e-9)
    np.testing.assert_allclose(inertia, inertia.T, atol=1e-12)


@given(st.tuples(moment, moment, moment), st.tuples(angle, angle, angle))
@settings(max_examples=50)
def test_repair_does_not_depend_on_the_axes(moments, angles):
    R = pin.rpy.rpyToMatrix(*angles)
    straight = physical_inertia(1.0, np.diag(moments))
    np.testing.assert_allclose(
        physical_inertia(1.0, R @ np.diag(moments) @ R.T), R @ straight @ R.T, atol=1e-9
    )


@pytest.mark.parametrize(
    ("mass", "moments"),
    [(1, (0.1, 0.1, 0.3)), (1, (-0.1, 0.1, 0.1)), (0, (0.1, 0.1, 0.1)), (-1, (0.1, 0.1, 0.1))],
)
def test_inertia_that_no_body_can_have_is_refused(mass, moments):
    assert not is_physical(mass, np.diag(moments))


def test_inertia_with_nan_is_not_physical():
    assert not is_physical(1.0, np.full((3, 3), np.nan))
    assert not is_physical(np.nan, np.eye(3))


def test_model_inertias_are_repaired_for_pinocchio_and_mujoco_with_a_finding(tmp_path):
    wrong = inertial("head").replace('ixx="0.015488"', 'ixx="0.9"')
    path = changed(tmp_path, (inertial("head"), wrong))
    robot = wbc.robot.load(path, **FEET)
    body = robot.model.inertias[robot.model.getJointId("neck")]
    assert is_physical(body.mass, body.inertia)
    assert [(f.code, f.subject) for f in robot.findings] == [("non-physical-inertia", "head")]
    assert robot.mass == pytest.approx(54.6)


def test_physical_inertias_are_not_changed():
    assert not wbc.robot.load("talos").findings
    assert not wbc.robot.load("g1").findings
    # Two of Romeo's arm bodies break the triangle inequality.
    assert {f.subject for f in wbc.robot.load("romeo").findings} == {
        "RShoulderYawLink",
        "RElbowYawLink",
    }
