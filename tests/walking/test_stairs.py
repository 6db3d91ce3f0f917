"""Stairs with footsteps given: up, over the landing and down."""

from __future__ import annotations

import numpy as np
import pytest

import wbc
from wbc.gait import Placement, SwingFoot
from wbc.sim import Mujoco, Staircase
from wbc.telemetry import Footstep


def footsteps_over(stairs: Staircase, walker: wbc.Walker) -> list[Footstep]:
    """Both feet onto each foothold."""
    start, half = walker.feet.middle.real, 0.5 * walker.gait.step_width
    return [
        Footstep(side, np.array([start + x, half if side == "left" else -half, height]), 0.0)
        for x, height in stairs.footholds()
        for side in ("left", "right")
    ]


@pytest.mark.parametrize(("name", "risers"), [("talos", (0.14,)), ("g1", (0.08,))])
def test_robot_climbs_stairs_and_descends_them(name, risers):
    robot = wbc.load(name)
    walker = wbc.Walker(robot)
    distance = robot.soles[0].half_length + 0.08
    stairs = Staircase(risers, tread=0.25, landing=0.5, distance=distance)
    steps = footsteps_over(stairs, walker)
    heights, quick = [], []

    def before_tick(time: float) -> None:
        state = walker.gait_state
        heights.append(state.stance.height)
        quick.append(state.on_stairs and (state.recovering or state.shortened))
        if time == 0.0:
            walker.follow(steps)

    duration = 1.5 + (len(steps) + 1) * walker.gait.step_duration
    with Mujoco(robot, terrain=stairs, seed=1) as plant:
        report = wbc.run(walker, plant, duration, before_tick=before_tick)
        truth = wbc.Kinematics(robot, plant.ground_truth())
    assert report.survived
    assert report.qp_failures == 0
    assert not any(quick)
    assert max(heights) == pytest.approx(sum(risers), abs=0.02)
    for sole, step in zip(robot.soles, steps[-2:], strict=True):
        # The estimate drifts a few centimetres on the way, and a step may catch the last one.
        x, _, z = truth.frame(sole.name).translation
        np.testing.assert_allclose((x, z), step.position[[0, 2]], atol=0.08)


@pytest.mark.parametrize("rise", [0.18, -0.18])
def test_swing_foot_clears_the_edges_of_both_stairs(rise):
    start, target = Placement(0j, 0.0), Placement(0.27 + 0j, 0.0, rise)
    swing = SwingFoot(start, target, 0.8, 0.06, 0.05)
    tread, half_length = 0.27, 0.1
    edge = 0.5 * tread  # of the upper stair, or of the one that the foot leaves
    for _ in range(399):
        swing.advance(0.002, target)
        x, _, z = swing.motion.position
        if rise > 0.0 and x + half_length > edge:
            assert z > rise - 1e-3
        if rise < 0.0 and x - half_length < edge:
            assert z > -1e-3
    swing.advance(0.002, target)
    np.testing.assert_allclose(swing.motion.position, [0.27, 0.0, rise], atol=1e-6)
