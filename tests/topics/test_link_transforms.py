"""The tree of transforms is that of the model, on every robot."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import wbc
from wbc.robot import available
from wbc.topics.link_transforms import MovingLinks, links


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
    joints = [link.joint for link in links(robot) if link.joint is not None]
    assert sorted(joints) == list(range(robot.na))


def test_link_transforms_equal_pinocchios(robot):
    rng = np.random.default_rng(0)
    every = links(robot)
    moving = [link for link in every if link.joint is not None]
    model, data = robot.model, robot.model.createData()
    q = robot.q_nominal.copy()
    q[7:] += rng.uniform(-1.0, 1.0, robot.na)
    pin.framesForwardKinematics(model, data, q)
    poses = dict(zip((m.name for m in moving), MovingLinks(moving).at(q[7:]), strict=True))
    for link in every:
        local = (
            pin.XYZQUATToSE3(poses[link.name])
            if link.joint is not None
            else link.before * link.after
        )
        placed = data.oMf[robot.frame_id(link.parent)] * local
        expected = data.oMf[robot.frame_id(link.name)]
        assert np.allclose(placed.homogeneous, expected.homogeneous, atol=1e-9), link.name
