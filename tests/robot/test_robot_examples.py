"""Every humanoid of example-robot-data loads, with its feet guessed or named."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc.robot

SOLE = {"height": -0.1, "length": 0.2, "width": 0.1}
POINT_FEET = {"left_foot": "FL_FOOT", "right_foot": "FR_FOOT"}
HUMANOIDS = {
    "talos_full_v2": {},
    "talos_full_v2_box": {},
    "talos_reduced": {"left_foot": "left_sole_link", "right_foot": "right_sole_link"},
    "talos_reduced_box": {},
    "talos_reduced_corrected": {},
    "g1_29dof_rev_1_0": {},
    "g1_29dof_with_hand_rev_1_0": {},
    "romeo_small": {},
    # Its fingers weigh nothing, so they are fixed.
    "romeo_description/urdf/romeo.urdf": {"fixed_joints": ("*Finger*", "*Thumb*", "?Hand")},
    # Its meshes are missing, so its soles are stated.
    "romeo_laas_small": {"fixed_joints": ("*gripper*",), "sole": SOLE},
    "icub": {},
    "icub_reduced": {},
    "human": {},
    "alexander_v1.lowerBodyOnly": {},
    "simple_humanoid_classical": {"sole": SOLE},
    "simple_humanoid_description/urdf/simple_humanoid.urdf": {"sole": SOLE},
    "bolt": POINT_FEET,
    "solo12": POINT_FEET,
}


@pytest.fixture(scope="module", params=HUMANOIDS)
def robot(request):
    return wbc.robot.load(request.param, **HUMANOIDS[request.param])


def test_example_robot_stands_on_level_soles(robot):
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    for sole in robot.soles:
        placement = data.oMf[sole.frame_id]
        np.testing.assert_allclose(placement.rotation[:, 2], [0, 0, 1], atol=1e-6)
        assert abs(placement.translation[2]) < 1e-6
    left, right = (data.oMf[sole.frame_id].translation for sole in robot.soles)
    assert left[1] > right[1]
    assert robot.com_height > 0.15


def test_example_robot_has_finite_invertible_dynamics(robot):
    model, data = robot.model, robot.model.createData()
    M = pin.crba(model, data, robot.q_nominal)
    M = np.triu(M) + np.triu(M, 1).T
    assert np.linalg.eigvalsh(M)[0] > 0
    acceleration = pin.aba(model, data, robot.q_nominal, np.zeros(model.nv), np.zeros(model.nv))
    assert np.isfinite(acceleration).all()


def test_example_robot_has_physical_inertias(robot):
    for body in list(robot.model.inertias)[1:]:
        assert body.mass > 0
        moments = np.linalg.eigvalsh(body.inertia)
        assert moments[0] > 0
        assert moments[2] <= (moments[0] + moments[1]) * (1 + 1e-5)


def test_example_robot_has_one_coordinate_per_joint(robot):
    assert robot.nq - 7 == robot.nv - 6 == robot.na == len(robot.joint_names)
    assert not np.isnan(robot.q_nominal).any()


def test_guessed_feet_are_derived_facts():
    facts = {fact.name: fact for fact in wbc.robot.load("icub_reduced").facts}
    assert facts["left foot"].value == "l_sole"
    assert facts["left foot"].origin == "derived"


def test_a_base_whose_y_axis_is_up_stands_upright():
    robot = wbc.robot.load("human")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    head = data.oMf[robot.frame_id("middle_head")].translation
    assert head[2] > 1.4
    assert abs(head[1]) < 0.05


def test_a_base_whose_x_axis_points_backwards_still_heads_forward():
    robot = wbc.robot.load("icub")
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, robot.q_nominal)
    assert data.oMf[robot.frame_id("l_sole")].translation[1] > 0
    np.testing.assert_allclose(data.oMi[1].rotation[:, 0], [-1, 0, 0], atol=1e-2)


def test_collada_files_that_mean_their_up_axis_are_turned():
    """iCub's foot lies along x only if its meshes' y axis is taken as up."""
    turned, plain = (wbc.robot.load("icub_reduced", respect_up_axis=up) for up in (None, False))
    assert turned.respect_up_axis
    assert not plain.respect_up_axis
    assert [fact.origin for fact in turned.facts if fact.name == "meshes"] == ["derived"]
    assert turned.soles[0].half_length > turned.soles[0].half_width
    assert plain.soles[0].half_length < plain.soles[0].half_width
    assert len(turned.visual_model.geometryObjects) == len(plain.visual_model.geometryObjects)
    foot = next(g for g in turned.collision_model.geometryObjects if g.name.startswith("l_foot"))
    box = foot.geometry
    box.computeLocalAABB()
    size = np.abs(foot.placement.rotation @ (box.aabb_local.max_ - box.aabb_local.min_))
    assert size[0] > 1.5 * size[1]


def test_missing_meshes_do_not_keep_the_dynamics_from_loading():
    robot = wbc.robot.load("romeo_laas_small", **HUMANOIDS["romeo_laas_small"])
    assert robot.mass == pytest.approx(40.8, abs=0.1)
    kinds = {type(g.geometry).__name__ for g in robot.visual_model.geometryObjects}
    assert not any("BVH" in kind for kind in kinds)


def test_three_slash_package_addresses_resolve():
    robot = wbc.robot.load("talos_full_v2_box")
    text = robot.urdf_path.read_text()
    assert "package:///" in text
    assert "unresolved-package" not in {finding.code for finding in robot.check()}
    assert "missing-mesh" not in {finding.code for finding in robot.check()}
