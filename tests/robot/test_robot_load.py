"""`load` by name: the four robots of the project, and what a Robot tells about itself."""

from __future__ import annotations

import time

import numpy as np
import pinocchio as pin
import pytest

import wbc.robot
from wbc.errors import FrameNotFound, JointNotFound

NAMES = ("talos", "g1", "romeo", "simple_humanoid")
# Published or measured on the description: degrees of freedom, kg, sole length and width, m.
KNOWN = {
    "talos": (32, 90.3, 0.20, 0.12),
    "g1": (29, 33.3, 0.17, 0.05),
    "romeo": (31, 40.5, 0.18, 0.08),
    "simple_humanoid": (20, 54.6, 0.22, 0.10),
}


@pytest.fixture(scope="module", params=NAMES)
def robot(request):
    return wbc.robot.load(request.param)


def test_the_robots_of_the_project_are_available():
    assert set(NAMES) <= set(wbc.robot.available())


def test_size_mass_and_soles_are_the_robots_own(robot):
    na, mass, length, width = KNOWN[robot.name]
    assert robot.na == na
    assert robot.nq == na + 7
    assert robot.nv == na + 6
    assert robot.mass == pytest.approx(mass, abs=0.1)
    for sole in robot.soles:
        assert 2 * sole.half_length == pytest.approx(length, abs=0.015)
        assert 2 * sole.half_width == pytest.approx(width, abs=0.012)


def test_standing_has_flat_soles_on_the_ground_around_the_origin_facing_x(robot):
    state = robot.standing()
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, state.q)
    left, right = (data.oMf[model.getFrameId(name)] for name in ("left_sole", "right_sole"))
    for sole in (left, right):
        np.testing.assert_allclose(sole.rotation[:, 2], [0, 0, 1], atol=1e-6)
        assert abs(sole.translation[2]) < 1e-6
    np.testing.assert_allclose(left.translation + right.translation, 0, atol=1e-9)
    assert left.translation[1] > 0.05
    heading = left.rotation[:, 0] + right.rotation[:, 0]
    np.testing.assert_allclose(heading / np.linalg.norm(heading), [1, 0, 0], atol=1e-9)
    assert not state.v.any()


def test_standing_returns_a_new_state_each_time(robot):
    state = robot.standing()
    state.q[0] = 7.0
    assert robot.standing().q[0] != 7.0
    with pytest.raises(ValueError, match="read-only"):
        robot.q_nominal[0] = 7.0


def test_nominal_posture_keeps_the_limits_and_the_mass_over_the_soles(robot):
    joints = robot.q_nominal[7:]
    assert (joints >= robot.q_min).all()
    assert (joints <= robot.q_max).all()
    com = pin.centerOfMass(robot.model, robot.model.createData(), robot.q_nominal)
    assert abs(com[0]) < 0.25 * robot.soles[0].half_length
    assert abs(com[1]) < 0.005
    assert com[2] == pytest.approx(robot.com_height)


def test_nominal_knees_are_bent(robot):
    model, data = robot.model, robot.model.createData()
    pin.framesForwardKinematics(model, data, robot.q_nominal)
    for side in ("left", "right"):
        sole, leg = robot.sole(side), robot.leg_joints(side)
        hip = next(j for j in range(2, model.njoints) if model.joints[j].idx_v == leg[0])
        reach = np.linalg.norm(data.oMi[hip].translation - data.oMf[sole.frame_id].translation)
        assert 0.8 * robot.leg_length < reach < 0.995 * robot.leg_length


def test_mass_matrix_is_positive_definite_without_armature(robot):
    model = robot.model.copy()
    model.armature = np.zeros(model.nv)
    M = pin.crba(model, model.createData(), robot.q_nominal)
    M = np.triu(M) + np.triu(M, 1).T
    assert np.linalg.eigvalsh(M)[0] > 1e-6


def test_model_equals_pinocchios_own(robot):
    """Cleaning the document changes nothing that a sound file says."""
    model = robot.model
    plain = pin.buildModelFromUrdf(str(robot.urdf_path), pin.JointModelFreeFlyer())
    assert list(model.names) == list(plain.names)
    assert [frame.name for frame in model.frames][:-2] == [frame.name for frame in plain.frames]
    repaired = {finding.subject for finding in robot.findings}
    for joint in range(1, model.njoints):
        assert model.jointPlacements[joint].isApprox(plain.jointPlacements[joint], 1e-12)
        links = {f.name for f in model.frames if f.parentJoint == joint}
        if not links & repaired:
            assert model.inertias[joint].isApprox(plain.inertias[joint], 1e-12)
    np.testing.assert_allclose(model.lowerPositionLimit[7:], plain.lowerPositionLimit[7:])
    np.testing.assert_allclose(model.upperPositionLimit[7:], plain.upperPositionLimit[7:])
    np.testing.assert_allclose(model.effortLimit, plain.effortLimit)
    np.testing.assert_allclose(model.velocityLimit, plain.velocityLimit)


def test_shapes_equal_pinocchios_own():
    robot = wbc.robot.load("simple_humanoid")
    plain = pin.buildGeomFromUrdf(robot.model, str(robot.urdf_path), pin.VISUAL)
    ours = robot.visual_model.geometryObjects
    assert [shape.name for shape in ours] == [shape.name for shape in plain.geometryObjects]
    for shape, other in zip(ours, plain.geometryObjects, strict=True):
        assert shape.placement.isApprox(other.placement, 1e-12)
        np.testing.assert_allclose(shape.meshColor, other.meshColor)


def test_armature_is_on_the_joints_only(robot):
    assert not robot.model.armature[:6].any()
    assert (robot.model.armature[6:] >= 0.01).all()


def test_limits_are_vectors_of_actuated_joints_and_read_only(robot):
    for values in (robot.tau_max, robot.v_max, robot.q_min, robot.q_max):
        assert values.shape == (robot.na,)
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0.0
    assert np.isfinite(robot.tau_max).all()
    assert (robot.tau_max > 0).all()
    assert (robot.v_max > 0).all()
    assert (robot.q_min < robot.q_max).all()


def test_legs_are_the_joints_that_move_each_sole(robot):
    model, data = robot.model, robot.model.createData()
    pin.computeJointJacobians(model, data, robot.q_nominal)
    for side in ("left", "right"):
        J = pin.getFrameJacobian(model, data, robot.sole(side).frame_id, pin.LOCAL_WORLD_ALIGNED)
        moving = 6 + np.flatnonzero(np.abs(J[:, 6:]).max(axis=0))
        assert set(robot.leg_joints(side)) == set(moving.tolist())
        assert len(robot.leg_joints(side)) == 6
    assert not set(robot.leg_joints("left")) & set(robot.leg_joints("right"))


def test_torso_base_and_imu_are_frames_and_the_torso_is_no_leg(robot):
    for name in (robot.torso, robot.base, robot.imu):
        assert robot.model.existFrame(name)
    torso = robot.model.frames[robot.frame_id(robot.torso)].parentJoint
    assert torso > 1  # each of the four has a waist
    assert robot.model.frames[robot.frame_id(robot.base)].parentJoint == 1


def test_soles_are_operational_frames_on_the_feet(robot):
    for sole in robot.soles:
        frame = robot.model.frames[sole.frame_id]
        assert frame.name == sole.name
        assert frame.type == pin.OP_FRAME
        assert frame.parentJoint == sole.joint_id
        assert frame.placement == sole.placement
        assert robot.sole(sole.name) is sole is robot.sole(sole.side)
        assert robot.model.existBodyName(sole.link)


def test_names_give_indices_and_unknown_ones_similar_names(robot):
    for i, name in enumerate(robot.joint_names):
        assert robot.joint_index(name) == i
        assert robot.model.joints[robot.model.getJointId(name)].idx_v == i + 6
    with pytest.raises(JointNotFound, match=r"no joint .*did you mean"):
        robot.joint_index(robot.joint_names[3] + "x")
    with pytest.raises(JointNotFound):
        robot.joint_index("root_joint")
    with pytest.raises(FrameNotFound, match=r"left_sole"):
        robot.frame_id("lef_sole")
    with pytest.raises(FrameNotFound, match=r"left_sole"):
        robot.sole("middle_sole")


def test_facts_distinguish_stated_and_derived_values(robot):
    facts = {fact.name: fact for fact in robot.facts}
    assert facts["left foot"].origin == "stated"
    assert facts["left sole"].origin == "derived"
    assert facts["torso"].value == robot.torso
    assert facts["armature"].source == f"{robot.name}.toml"
    assert "mm from the soles' midpoint" in facts["nominal posture"].value


def test_loading_a_robot_reads_no_meshes():
    wbc.robot.load("talos")
    begin = time.thread_time()
    robot = wbc.robot.load("talos")
    loaded = time.thread_time()
    assert "visual_model" not in vars(robot)
    assert robot.visual_model.ngeoms > 0
    # A sixteenth, measured.
    assert loaded - begin < 0.5 * (time.thread_time() - loaded)


def test_two_loaded_robots_share_no_data():
    one, other = wbc.robot.load("simple_humanoid"), wbc.robot.load("simple_humanoid")
    mass = other.model.inertias[1].mass
    one.model.inertias[1] = pin.Inertia.Random()
    assert other.model.inertias[1].mass == mass


def test_visual_and_collision_shapes_come_on_demand():
    robot = wbc.robot.load("simple_humanoid")
    assert robot.visual_model is robot.visual_model
    drawn = {robot.model.names[g.parentJoint] for g in robot.visual_model.geometryObjects}
    assert {"neck", "left_knee", "right_elbow", "left_ankle_roll"} <= drawn
    assert len(robot.collision_model.geometryObjects) == 23
