"""The tree of transforms is that of the model, on every robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.messages import message_type
from wbc.robot import available
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.schema import Schema, declared_columns
from wbc.topics import BatchMaker
from wbc.topics.link_transforms import (
    Link,
    LinkPoses,
    fixed_link_transforms,
    links,
    moving_link_transforms,
)
from wbc.topics.standard_frames import standard_frames


@pytest.fixture(scope="module", params=available())
def robot(request):
    return wbc.load(request.param)


def test_every_link_but_the_root_has_one_parent(robot):
    every = links(robot)
    names = [link.name for link in every]
    assert len(set(names)) == len(names)
    bodies = {f.name for f in robot.model.frames if f.type == pin.BODY}
    assert set(names) | {robot.base} == bodies | {sole.name for sole in robot.soles}
    assert {link.parent for link in every} <= bodies


def test_every_joint_moves_one_link(robot):
    assert sum(link.moves for link in links(robot)) == robot.na


def test_link_transforms_equal_pinocchios(robot):
    rng = np.random.default_rng(0)
    model, data = robot.model, robot.model.createData()
    q = robot.q_nominal.copy()
    q[7:] += rng.uniform(-1.0, 1.0, robot.na)
    moving = [link for link in links(robot) if link.moves]
    poses = dict(zip(moving, LinkPoses(robot, moving).at(q), strict=True))
    static = message_type("tf2_msgs/msg/TFMessage").decode(fixed_link_transforms(robot).data)
    standard = {frame.name for frame in standard_frames(robot)}
    for one in static.transforms:
        if one.child_frame_id in standard:
            continue
        x, turn = one.transform.translation, one.transform.rotation
        link = Link(one.child_frame_id, one.header.frame_id, moves=False)
        poses[link] = np.array([x.x, x.y, x.z, turn.x, turn.y, turn.z, turn.w])
    assert set(poses) == set(links(robot))
    pin.framesForwardKinematics(model, data, q)
    for link, pose in poses.items():
        placed = data.oMf[robot.frame_id(link.parent)] * pin.XYZQUATToSE3(pose)
        expected = data.oMf[robot.frame_id(link.name)]
        assert np.allclose(placed.homogeneous, expected.homogeneous, atol=1e-9), link.name


def all_transforms(robot, q):
    """Return the transforms of all frames of both topics at a configuration, by their children."""
    schema = Schema(tuple(column for column, _ in declared_columns(robot, QUANTITIES)))
    record = np.zeros(1, schema.dtype)
    record["q"] = q
    batch = BatchMaker(robot).batch(record, np.array([0]))
    ((_, data),) = moving_link_transforms(robot, 0.0).messages(batch)
    decode = message_type("tf2_msgs/msg/TFMessage").decode
    found = {}
    for message in (decode(data[0].tobytes()), decode(fixed_link_transforms(robot).data)):
        for one in message.transforms:
            x, turn = one.transform.translation, one.transform.rotation
            pose = pin.XYZQUATToSE3(np.array([x.x, x.y, x.z, turn.x, turn.y, turn.z, turn.w]))
            assert one.child_frame_id not in found
            found[one.child_frame_id] = (one.header.frame_id, pose)
    return found


def placement(transforms, frame):
    pose = pin.SE3.Identity()
    while frame != "odom":
        frame, relative = transforms[frame]
        pose = relative * pose
    return pose


def test_every_robot_has_the_frames_of_rep_120(robot):
    state = robot.standing()
    turned = state.q.copy()
    tilt = pin.rpy.rpyToMatrix(0.1, 0.05, 0.7)
    turned[3:7] = pin.SE3ToXYZQUAT(pin.SE3(tilt, np.zeros(3)))[3:]
    turned[:2] += (2.0, -1.0)
    transforms = all_transforms(robot, turned)
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, turned)
    for name, own in (
        ("base_link", robot.base),
        ("l_sole", robot.soles[0].name),
        ("r_sole", robot.soles[1].name),
    ):
        own = name if robot.model.existFrame(name) else own  # the URDF's own frame stays
        expected = data.oMf[robot.frame_id(own)].homogeneous
        assert np.allclose(placement(transforms, name).homogeneous, expected, atol=1e-6)
    footprint = placement(transforms, "base_footprint")
    soles = np.array([data.oMf[robot.frame_id(sole.name)].translation for sole in robot.soles])
    assert np.allclose(footprint.translation[:2], soles.mean(axis=0)[:2])
    assert footprint.translation[2] == pytest.approx(soles[:, 2].min())
    assert np.allclose(pin.rpy.matrixToRpy(footprint.rotation)[:2], 0.0, atol=1e-9)
    if "gaze" in transforms:
        ahead = placement(all_transforms(robot, state.q), "gaze")
        assert np.allclose(ahead.rotation, np.eye(3), atol=1e-6)
