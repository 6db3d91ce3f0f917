"""The tree of transforms is that of the model, on every robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.messages import message_type
from wbc.robot import available
from wbc.topics.link_transforms import Link, LinkPoses, fixed_link_transforms, links


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
    for one in static.transforms:
        x, turn = one.transform.translation, one.transform.rotation
        link = Link(one.child_frame_id, one.header.frame_id, moves=False)
        poses[link] = np.array([x.x, x.y, x.z, turn.x, turn.y, turn.z, turn.w])
    assert set(poses) == set(links(robot))
    pin.framesForwardKinematics(model, data, q)
    for link, pose in poses.items():
        placed = data.oMf[robot.frame_id(link.parent)] * pin.XYZQUATToSE3(pose)
        expected = data.oMf[robot.frame_id(link.name)]
        assert np.allclose(placed.homogeneous, expected.homogeneous, atol=1e-9), link.name
