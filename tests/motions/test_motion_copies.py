"""A copied motion player continues bit for bit as its original."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import wbc
from wbc.errors import MotionError
from wbc.motions import Bow, MotionPlayer, Sway
from wbc.sim import Mujoco

COPIES = {"deepcopy": copy.deepcopy, "pickle": lambda x: pickle.loads(pickle.dumps(x))}


def torques(player: MotionPlayer, state: wbc.State, ticks: int) -> np.ndarray:
    """Return the torques of some ticks of a robot that does not move, (ticks, na), N·m."""
    estimate = wbc.Estimate(state)
    return np.array([player.step(estimate).tau for _ in range(ticks)])


@pytest.fixture(scope="module")
def robot() -> wbc.Robot:
    return wbc.load("simple_humanoid")


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
def test_a_copy_with_a_waiting_motion_plays_it_identically(robot, make):
    player = MotionPlayer(robot, motions=[Bow(angle=15.0, seconds=0.5, hold=0.1)])
    state = robot.standing()
    twin = make(player)
    np.testing.assert_array_equal(torques(player, state, 150), torques(twin, state, 150))
    assert twin.playing == player.playing is not None


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
def test_a_copy_in_mid_walk_walks_and_plays_on_identically(robot, make):
    player = MotionPlayer(robot)
    sway = Sway(size=0.02, rounds=1)
    sway.prepare(robot)
    with Mujoco(robot, dt=player.dt, seed=3) as plant:
        player.reset(plant.ground_truth())
        estimator = wbc.Estimator(robot, player.dt)
        estimator.reset(plant.ground_truth())
        player.velocity = (0.2, 0.0, 0.0)
        twin: MotionPlayer | None = None
        for tick in range(900):
            estimate = estimator.update(plant.measure())
            if tick == 400:
                twin = make(player)
            if tick == 500:
                for one in (player, twin):
                    assert one is not None
                    one.velocity = (0.0, 0.0, 0.0)
                    one.interrupt(sway)
            command = player.step(estimate)
            if twin is not None:
                np.testing.assert_array_equal(command.tau, twin.step(estimate).tau)
            plant.step(command)


@pytest.mark.parametrize("make", COPIES.values(), ids=COPIES)
def test_a_player_in_the_middle_of_a_script_refuses_to_be_copied(robot, make):
    player = MotionPlayer(robot, motions=[Sway(size=0.02)])
    torques(player, robot.standing(), 5)
    with pytest.raises(MotionError, match="cannot be copied during 'sway'"):
        make(player)
