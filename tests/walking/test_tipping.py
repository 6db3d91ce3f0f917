"""The support foot of a quick step tips over the edge that the DCM has left."""

import math
from dataclasses import replace

import numpy as np
import pytest

import wbc
from wbc.gait import Feet, GaitParameters, GaitState, Phase, Placement
from wbc.qp.inputs import packed_text, packed_values
from wbc.recorded_tick import recorded_controller
from wbc.runtime.controller_inputs import controller_inputs
from wbc.sim import Mujoco
from wbc.walking.gains import WalkerGains
from wbc.walking.stabilizer.support_polygon import SupportPolygon
from wbc.walking.stabilizer.tipping import edge_to_tip_over

pytest.importorskip("mujoco")

BEYOND = WalkerGains().tipping_distance


@pytest.fixture(scope="module")
def g1():
    return wbc.load("g1")


def swinging(robot, dcm):
    """State of a quick step on the left foot, and the ZMP that its DCM (sole's axes) asks for."""
    walker = wbc.Walker(robot)
    state = walker.gait_state
    state.phase, state.support, state.shortened = Phase.SWING, "left", True
    state.dcm = state.stance.to_world(dcm)
    return state, state.stance.to_world(1.5 * dcm)


@pytest.mark.parametrize("edge", [1 + 0j, -1 + 0j, 1j, -1j])
def test_a_foot_tips_over_the_edge_that_the_dcm_has_left(g1, edge):
    support, sole = SupportPolygon(g1), g1.soles[0]
    reach = sole.half_length if edge.real else sole.half_width
    state, zmp = swinging(g1, (reach + 0.2 * g1.com_height) * edge)
    assert edge_to_tip_over(state, zmp, support, BEYOND) == edge
    state.shortened = False  # an undisturbed robot brings its DCM back
    assert edge_to_tip_over(state, zmp, support, BEYOND) == 0j
    state, zmp = swinging(g1, (reach + 0.05 * g1.com_height) * edge)
    assert edge_to_tip_over(state, zmp, support, BEYOND) == 0j


def test_the_heel_is_free_late_in_a_fast_swing_once_the_pressure_is_on_its_way_to_the_toe():
    robot = wbc.load("simple_humanoid")
    gait, support = GaitParameters.for_robot(robot), SupportPolygon(robot)
    feet = Feet(Placement(0j, 0.0), Placement(complex(0.0, -gait.step_width), 0.0))
    state = GaitState(gait, feet, replace(gait, single_support=0.2))
    state.phase, state.duration, state.time, state.fast_share = Phase.SWING, 0.4, 0.36, 1.0
    toe = robot.soles[0].half_length
    assert edge_to_tip_over(state, complex(0.8 * toe), support, BEYOND) == 1 + 0j
    assert edge_to_tip_over(state, 0j, support, BEYOND) == 0j
    state.time = 0.2
    assert edge_to_tip_over(state, complex(0.8 * toe), support, BEYOND) == 0j
    state.time, state.fast_share = 0.4, 0.0
    assert edge_to_tip_over(state, complex(math.inf), support, BEYOND) == 0j


def pushed(robot, seed=3, at=2.2, size=1.0):
    """Push a robot that walks to its support foot's side, by `size` N·s/kg; yields walker and
    command per tick."""
    walker = wbc.Walker(robot)
    estimator = wbc.Estimator(robot, walker.dt)
    walker.velocity = (0.3, 0.0, 0.0)
    with Mujoco(robot, seed=seed) as plant:
        plant.schedule_push(at, robot.mass * np.array([0.0, size, 0.0]))
        estimator.reset(plant.ground_truth())
        expected = None
        for _ in range(round(4.2 / walker.dt)):
            command = walker.step(estimator.update(plant.measure(), acceleration=expected))
            expected = command.acceleration
            plant.step(command)
            yield walker, command
            if walker.falling_why:
                return


def test_a_robot_that_is_pushed_towards_its_support_foot_tips_it_and_goes_on(g1):
    tilt, again = 0.0, None
    for walker, command in pushed(g1):
        state, kin = walker.gait_state, walker.kinematics
        if state.tipping.imag != 0.0:
            normal = kin.frame(f"{state.support}_sole").rotation[:, 2]
            tilt = max(tilt, math.acos(min(normal[2], 1.0)))
            if again is None and tilt > 0.1:
                words = command.source.packed_inputs(command, controller_inputs(g1).size).copy()
                again = recorded_controller(g1, packed_text(words), packed_values(words))
                solved = again.step(kin.state)
                np.testing.assert_allclose(solved.tau, command.tau, atol=1e-9)
    assert not walker.falling_why
    assert tilt > math.radians(10.0)
    assert again is not None


@pytest.mark.slow
def test_such_pushes_fell_a_robot_that_holds_its_foot_flat_more_often(g1, monkeypatch):
    def falls() -> int:
        pushes = [(seed, at) for seed in range(3, 11) for at in (2.19, 2.20, 2.21)]
        return sum(bool([*pushed(g1, *push, size=1.1)][-1][0].falling_why) for push in pushes)

    tipping = falls()
    module = "wbc.walking.stabilizer.stabilizer.edge_to_tip_over"
    monkeypatch.setattr(module, lambda *_: 0j)
    assert falls() >= tipping + 3
