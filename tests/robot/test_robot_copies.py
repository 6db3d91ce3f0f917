"""A robot is immutable: copies share it, and a pickled one is rebuilt exactly."""

from __future__ import annotations

import copy
import dataclasses
import pickle

import numpy as np
import pinocchio as pin
import pytest
from robottools import FEET, changed

import wbc.robot

ARRAYS = ("q_nominal", "tau_max", "v_max", "q_min", "q_max")


def without_velocity_limit(folder):
    """Our robot with one joint whose velocity limit is absent: infinite limits must survive."""
    return changed(folder, ('velocity="8"', 'velocity="0"'))


def test_copy_of_a_robot_returns_the_same_object():
    robot = wbc.robot.load("simple_humanoid")
    assert copy.copy(robot) is robot
    assert copy.deepcopy(robot) is robot
    assert copy.deepcopy({"robots": [robot]})["robots"][0] is robot


def test_a_robot_cannot_be_changed():
    robot = wbc.robot.load("simple_humanoid")
    with pytest.raises(dataclasses.FrozenInstanceError):
        robot.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        robot.q_nominal[0] = 1.0


@pytest.mark.parametrize("name", ["talos", "g1", "infinite"])
def test_a_pickled_robot_has_the_same_limits_and_bit_identical_dynamics(name, tmp_path):
    if name == "infinite":
        robot = wbc.robot.load(without_velocity_limit(tmp_path), **FEET)
        assert np.isinf(robot.v_max).any()
    else:
        robot = wbc.robot.load(name)
    again = pickle.loads(pickle.dumps(robot))
    assert again.name == robot.name
    assert again.legs == robot.legs
    assert again.facts == robot.facts
    assert again.findings == robot.findings
    for attribute in ARRAYS:
        ours, theirs = getattr(robot, attribute), getattr(again, attribute)
        np.testing.assert_array_equal(theirs, ours)
        assert not theirs.flags.writeable
    for ours, theirs in zip(robot.soles, again.soles, strict=True):
        np.testing.assert_array_equal(theirs.placement.homogeneous, ours.placement.homogeneous)
        assert (theirs.name, theirs.frame_id, theirs.link) == (ours.name, ours.frame_id, ours.link)
    rng = np.random.default_rng(0)
    q = pin.integrate(robot.model, robot.q_nominal, 0.3 * rng.normal(size=robot.nv))
    v, a = rng.normal(size=(2, robot.nv))
    torques = [pin.rnea(r.model, r.model.createData(), q, v, a) for r in (robot, again)]
    np.testing.assert_array_equal(torques[1], torques[0])
    masses = [pin.crba(r.model, r.model.createData(), q) for r in (robot, again)]
    np.testing.assert_array_equal(masses[1], masses[0])


def test_a_pickled_robot_leaves_its_meshes_and_still_finds_them(tmp_path):
    robot = wbc.robot.load("simple_humanoid")
    shapes = robot.visual_model.ngeoms
    again = pickle.loads(pickle.dumps(robot))
    assert "visual_model" not in vars(again)
    assert again.visual_model.ngeoms == shapes


def test_a_robot_shows_its_name_joints_mass_and_feet():
    robot = wbc.robot.load("simple_humanoid")
    shown = repr(robot)
    assert shown.startswith("Robot('simple_humanoid', 20 joints, 54.6 kg, soles 220 × 100 mm on")
    assert "'left_foot'" in shown
    assert repr(robot.soles[0]) == "Sole('left_sole', 220 × 100 mm, on 'left_foot')"
    assert all(repr(fact).startswith("Fact('") for fact in robot.facts)


def test_weight_is_mass_times_the_models_gravity():
    robot = wbc.robot.load("simple_humanoid")
    assert robot.gravity == pytest.approx(9.81)
    assert robot.weight == pytest.approx(robot.mass * robot.gravity)
