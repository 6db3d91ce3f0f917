"""Soles and the plane geometry under them."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from robottools import FEET, changed, element

import wbc.robot
from wbc.geometry.polygon import convex_hull
from wbc.robot.foot_surface import FootSurface, foot_surface
from wbc.robot.sole_fitting import fit_sole


def inside(hull, p, slack=1e-9):
    hull = np.array([[corner.real, corner.imag] for corner in hull])
    a, b = hull, np.roll(hull, -1, axis=0)
    edge, to = b - a, p - a
    length = np.linalg.norm(edge, axis=1)
    return ((edge[:, 0] * to[:, 1] - edge[:, 1] * to[:, 0]) / length >= -slack).all()


def box(length, width, height):
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 0)], dtype=float)
    return signs * [0.5 * length, 0.5 * width, height]


angles = st.floats(-np.pi, np.pi)


@given(
    length=st.floats(0.1, 0.3),
    width=st.floats(0.05, 0.09),
    turn=st.tuples(angles, angles, angles),
    tilt=st.floats(-0.06, 0.06),
)
@settings(max_examples=50)
def test_a_box_foot_is_found_in_any_axes_and_under_a_tilted_frame(length, width, turn, tilt):
    """The foot link may have swapped axes, and its frame may be tilted against its sole."""
    R = pin.rpy.rpyToMatrix(*turn)  # from a level frame, x forward, to the joint's axes
    surface = FootSurface(box(length, width, 0.05) @ R.T, np.zeros(8), "collision")
    tilted = R @ pin.rpy.rpyToMatrix(0.0, tilt, 0.0)
    fit = fit_sole(surface, R[:, 2], R[:, 0], tilted)
    # A tilt of two tenths of a millimetre along the sole is taken for rounding.
    exact = tilt == 0.0 or abs(tilt) > 3e-3
    np.testing.assert_allclose(fit.placement.rotation, R, atol=1e-9 if exact else 3e-3)
    slack = 1e-6 if exact else 1e-3
    np.testing.assert_allclose(R.T @ fit.placement.translation, [0, 0, -0.05], atol=slack)
    assert fit.half_length == pytest.approx(length / 2, abs=slack)
    assert fit.half_width == pytest.approx(width / 2, abs=slack)


@given(lean=st.floats(-0.1, 0.1))
@settings(max_examples=30)
def test_a_foot_that_stands_tilted_snaps_to_its_own_flat_side(lean):
    """The posture in which a sole is looked for need not be quite level."""
    up = pin.rpy.rpyToMatrix(0.0, lean, 0.0)[:, 2]
    surface = FootSurface(box(0.2, 0.1, 0.05), np.zeros(8), "collision")
    fit = fit_sole(surface, up, np.array([1.0, 0, 0]), np.eye(3))
    np.testing.assert_allclose(fit.placement.rotation, np.eye(3), atol=1e-9)
    assert fit.half_length == pytest.approx(0.1, abs=1e-6)


def test_sole_of_sphere_feet_lies_below_the_centres():
    centres = np.array([[0.1, 0.03, 0], [0.1, -0.03, 0], [-0.1, 0.03, 0], [-0.1, -0.03, 0.0]])
    fit = fit_sole(
        FootSurface(centres, np.full(4, 0.005), "collision"),
        np.array([0, 0, 1.0]),
        np.array([1.0, 0, 0]),
        np.eye(3),
    )
    assert fit.placement.translation == pytest.approx([0, 0, -0.005])
    assert (fit.half_length, fit.half_width) == pytest.approx((0.1, 0.03))


def test_rounded_edges_do_not_count_as_sole():
    flat = box(0.2, 0.1, 0.05)
    rim = box(0.24, 0.14, 0.04)  # one centimetre higher all round
    surface = FootSurface(np.vstack([flat, rim]), np.zeros(16), "collision")
    fit = fit_sole(surface, np.array([0, 0, 1.0]), np.array([1.0, 0, 0]), np.eye(3))
    assert fit.half_length == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "simple_humanoid", "icub", "human"])
def test_sole_rectangles_lie_within_the_foots_outline(name):
    robot = wbc.robot.load(name)
    for sole in robot.soles:
        surface = foot_surface(
            robot.urdf, robot.model, sole.joint_id, robot.package_dirs, robot.respect_up_axis
        )
        low = surface.lowest(sole.placement.rotation[:, 2])
        local = (low - sole.placement.translation) @ sole.placement.rotation
        assert local[:, 2].min() == pytest.approx(0, abs=1e-9)
        hull = convex_hull(complex(x, y) for x, y in local[:, :2])
        for corner in sole.corners:
            assert inside(hull, corner[:2], 1e-6)


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "simple_humanoid", "icub"])
def test_left_and_right_soles_mirror_each_other(name):
    left, right = wbc.robot.load(name).soles
    assert left.half_length == pytest.approx(right.half_length, abs=1e-3)
    assert left.half_width == pytest.approx(right.half_width, abs=1e-3)


@pytest.mark.parametrize(
    "posture",
    [
        {"left_knee": 0.8, "right_knee": 0.8},
        {"left_knee": 0.8, "right_knee": 0.8, "left_hip_pitch": 0.3, "right_ankle_roll": -0.3},
        {"left_elbow": 0.5},
    ],
)
def test_soles_do_not_depend_on_the_nominal_posture(posture):
    plain = wbc.robot.load("simple_humanoid").soles
    posed = wbc.robot.load("simple_humanoid", nominal_posture=posture).soles
    for ours, theirs in zip(plain, posed, strict=True):
        np.testing.assert_array_equal(theirs.placement.homogeneous, ours.placement.homogeneous)
        assert (theirs.half_length, theirs.half_width) == (ours.half_length, ours.half_width)


def test_soles_are_found_under_feet_that_are_far_from_level_in_the_zero_position(tmp_path):
    old = '<child link="{0}_ankle"/><origin xyz="0 0 -0.38"/>'
    new = '<child link="{0}_ankle"/><origin xyz="0 0 -0.38" rpy="0 0.8 0"/>'
    sides = [(old.format(side), new.format(side)) for side in ("left", "right")]
    plain = wbc.robot.load("simple_humanoid").soles
    for ours, theirs in zip(
        plain, wbc.robot.load(changed(tmp_path, *sides), **FEET).soles, strict=True
    ):
        np.testing.assert_allclose(theirs.placement, ours.placement, atol=1e-9)
        assert theirs.half_length == pytest.approx(ours.half_length, abs=1e-9)


def test_a_link_named_like_a_sole_keeps_its_name(tmp_path):
    link = (
        '<link name="left_sole"/><joint name="left_sole_fixed" type="fixed">'
        '<parent link="left_foot"/><child link="left_sole"/><origin xyz="0 0 -0.08"/></joint>'
        "</robot>"
    )
    robot = wbc.robot.load(changed(tmp_path, ("</robot>", link)), **FEET)
    left, right = robot.soles
    assert (left.name, right.name) == ("left_sole_contact", "right_sole_contact")
    assert robot.frame_id(left.name) == left.frame_id
    link_frame = robot.model.frames[robot.frame_id("left_sole")]
    np.testing.assert_allclose(link_frame.placement.translation, [0.0, 0.0, -0.08])
    assert robot.sole("left") is left


def test_feet_of_which_one_lacks_a_collision_shape_are_measured_alike(tmp_path):
    right = element("link", "right_foot")
    bare = re.sub(r"\s*<collision>.*</collision>", "", right)
    robot = wbc.robot.load(changed(tmp_path, (right, bare)))
    facts = [fact.source for fact in robot.facts if fact.name.endswith("sole")]
    assert [source.split()[0] for source in facts] == ["visual", "visual"]
    left, right = ((sole.half_length, sole.half_width) for sole in robot.soles)
    assert left == pytest.approx(right, abs=1e-6)
