"""Strict priorities at velocity level: what a lower level asks for leaves higher ones alone."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import hand, random_state, robot
from level_problems import stationarity

import wbc
from wbc.qp.solvers.hierarchical import HierarchicalSolver


def stack(bot: wbc.Robot, priorities: tuple[int, int, int]) -> wbc.InverseKinematics:
    """Feet and CoM, then a hand, then posture."""
    ik = wbc.InverseKinematics(bot)
    for sole in bot.soles:
        ik.add(wbc.FrameTask(sole.name, priority=priorities[0], name=f"{sole.name} stands"))
    ik.add(wbc.ComTask(priority=priorities[0]))
    ik.add(wbc.PositionTask(hand(bot), name="hand", priority=priorities[1]))
    ik.add(wbc.PostureTask(bot, priority=priorities[2]))
    return ik


def com_speed(ik: wbc.InverseKinematics, v: np.ndarray) -> float:
    data = ik.robot.model.createData()
    J = pin.jacobianCenterOfMass(ik.robot.model, data, ik.kinematics.state.q)
    return float(np.linalg.norm(J @ v))


def test_each_level_of_a_velocity_is_optimal():
    bot = robot("talos")
    for seed in range(6):
        ik = stack(bot, (1, 2, 3))
        state = random_state(bot, seed, spread=0.1)
        ik.step(state.q, 0.01)
        ik.tasks[3].velocity[:] = (1.0, -0.5, 2.0)
        ik.step(state.q, 0.01)
        x = HierarchicalSolver().solve(ik.problem).x
        assert max(stationarity(ik.problem, x)) < 1e-8


@pytest.mark.parametrize("priorities", [(1, 1, 1), (1, 2, 3)])
def test_a_hand_that_is_too_fast_moves_the_com_only_when_both_are_weighted(priorities):
    bot = robot("talos")
    ik = stack(bot, priorities)
    q = bot.standing().q
    ik.step(q, 0.01)
    ik.tasks[3].velocity[0] = 20.0
    speed = com_speed(ik, ik.step(q, 0.01))
    assert (speed < 1e-7) == (priorities == (1, 2, 3))
