"""Our own robot: the chapter's joints, a human's proportions, solids of its shapes."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from robottools import SIMPLE

import wbc.robot
from wbc.robot.description import read_description
from wbc.robot.inertia import is_physical
from wbc.robot.urdf import floats

# The 15 joints that the chapter's publisher sends, and those that its robot lacked.
CHAPTER = {"torso_yaw"} | {
    f"{side}_{joint}"
    for side in ("right", "left")
    for joint in (
        *("hip_pitch", "hip_roll", "knee", "ankle_pitch", "ankle_roll"),
        *("shoulder_pitch", "elbow"),
    )
}
ADDED = {"neck"} | {
    f"{side}_{joint}" for side in ("right", "left") for joint in ("hip_yaw", "shoulder_roll")
}
LINKS = {"base_link", "head"} | {
    f"{side}_{link}"
    for side in ("right", "left")
    for link in ("thigh", "shin", "foot", "upper_arm", "forearm", "hand")
}


@pytest.fixture(scope="module")
def robot():
    return wbc.robot.load("simple_humanoid")


def placements(robot, **joints):
    q = robot.q_nominal.copy()
    q[7:] = 0.0
    for name, value in joints.items():
        q[7 + robot.joint_index(name)] = value
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    return {frame.name: data.oMf[i] for i, frame in enumerate(robot.model.frames)}


def test_simple_humanoid_has_the_tutorials_joints_and_links(robot):
    assert len(CHAPTER) == 15
    assert set(robot.joint_names) == CHAPTER | ADDED
    assert set(read_description(SIMPLE).links) >= LINKS


def test_every_link_has_mass_and_every_body_part_is_drawn_and_collides():
    for name, link in read_description(SIMPLE).links.items():
        assert link.find("inertial") is not None, name
        assert link.find("collision") is not None, name
        if not name.endswith("hip_fork"):  # hidden inside the hip
            assert link.find("visual") is not None, name


def solid(shape, mass):
    """Moments of a homogeneous solid about its centre, kg·m²."""
    if shape.tag == "box":
        x, y, z = floats(shape, "size", (0, 0, 0))
        return mass / 12 * np.array([y * y + z * z, x * x + z * z, x * x + y * y])
    radius = floats(shape, "radius", (0,))[0]
    if shape.tag == "sphere":
        return np.full(3, 0.4 * mass * radius**2)
    length = floats(shape, "length", (0,))[0]
    across = mass * (3 * radius**2 + length**2) / 12
    return np.array([across, across, 0.5 * mass * radius**2])


def volume(shape):
    if shape.tag == "box":
        return float(np.prod(floats(shape, "size", (0, 0, 0))))
    radius = floats(shape, "radius", (0,))[0]
    if shape.tag == "sphere":
        return 4 / 3 * np.pi * radius**3
    return np.pi * radius**2 * floats(shape, "length", (0,))[0]


def test_each_inertia_of_simple_humanoid_is_that_of_its_solid_shape():
    for name, link in read_description(SIMPLE).links.items():
        inertia, shape = link.find("inertial/inertia"), link.find("collision/geometry")[0]
        mass = floats(link.find("inertial/mass"), "value", (0,))[0]
        moments = [floats(inertia, key, (0,))[0] for key in ("ixx", "iyy", "izz")]
        assert is_physical(mass, np.diag(moments)), name
        np.testing.assert_allclose(moments, solid(shape, mass), rtol=1e-4, err_msg=name)
        centre = floats(link.find("inertial/origin"), "xyz", (0, 0, 0))
        assert centre == floats(link.find("collision/origin"), "xyz", (0, 0, 0)), name
        # Between plastic foam and steel.
        assert 400 < mass / volume(shape) < 4000, name


def test_simple_humanoid_has_human_proportions(robot):
    frames = placements(robot)
    sole = frames["left_sole"].translation[2]
    height = frames["head"].translation[2] + 0.13 + 0.11 - sole
    assert 1.5 < height < 1.75
    assert 40 < robot.mass < 60
    hip = frames["left_thigh"].translation - frames["right_thigh"].translation
    np.testing.assert_allclose(hip, [0, 0.2, 0], atol=1e-9)
    assert 0.45 < (frames["left_thigh"].translation[2] - sole) / height < 0.55


def test_a_positive_knee_bends_and_a_positive_elbow_bends(robot):
    straight, bent = placements(robot), placements(robot, left_knee=1.0, left_elbow=1.0)
    ankle = bent["left_foot"].translation - straight["left_foot"].translation
    hand = bent["left_hand"].translation - straight["left_hand"].translation
    assert ankle[0] < -0.2
    assert ankle[2] > 0.1
    assert hand[0] > 0.15
    assert hand[2] > 0.05
    assert robot.q_min[robot.joint_index("left_knee")] == 0
    assert robot.q_min[robot.joint_index("left_elbow")] == 0


def test_left_and_right_mirror_each_other(robot):
    for name in robot.joint_names:
        if not name.startswith("left_"):
            continue
        left, right = robot.joint_index(name), robot.joint_index(name.replace("left", "right"))
        assert robot.tau_max[left] == robot.tau_max[right]
        if name.endswith(("roll", "yaw")):
            assert robot.q_min[left] == -robot.q_max[right]
            assert robot.q_max[left] == -robot.q_min[right]
        else:
            assert robot.q_min[left] == robot.q_min[right]
            assert robot.q_max[left] == robot.q_max[right]


def test_simple_humanoid_reaches_above_its_shoulders(robot):
    frames = placements(
        robot, right_shoulder_pitch=-1.57, right_shoulder_roll=-1.57, right_elbow=1.57
    )
    shoulder = frames["right_upper_arm"].translation
    assert frames["right_hand"].translation[2] > shoulder[2] + 0.2
    assert frames["right_hand"].translation[1] < shoulder[1] - 0.2
    for joint, value in (("right_shoulder_pitch", -1.57), ("right_shoulder_roll", -1.57)):
        i = robot.joint_index(joint)
        assert robot.q_min[i] < value < robot.q_max[i]


def test_simple_humanoid_squats_to_half_its_leg_length(robot):
    frames = placements(robot, left_hip_pitch=-1.25, left_knee=2.2, left_ankle_pitch=-0.95)
    high = placements(robot)
    drop = (high["left_thigh"].translation - high["left_foot"].translation)[2] - (
        frames["left_thigh"].translation - frames["left_foot"].translation
    )[2]
    assert drop > 0.35


def test_simple_humanoid_has_human_torque_limits(robot):
    effort = dict(zip(robot.joint_names, robot.tau_max, strict=True))
    assert 150 <= effort["left_knee"] <= 250
    assert 100 <= effort["left_ankle_pitch"] <= 180
    assert 60 <= effort["left_ankle_roll"] <= 100
    assert effort["neck"] == 10  # the chapter's
    assert ((robot.v_max >= 6) & (robot.v_max <= 12)).all()


def test_simple_humanoid_has_no_findings(robot):
    assert robot.check() == []
