"""Edges over which a support foot tips."""

from __future__ import annotations

import math
from dataclasses import replace

import wbc
from wbc.gait import Feet, GaitParameters, GaitState, Phase, Placement
from wbc.walking.stabilizer.support_polygon import SupportPolygon
from wbc.walking.stabilizer.tipping import edge_to_tip_over


def test_the_heel_is_free_late_in_a_fast_swing_once_the_pressure_is_on_its_way_to_the_toe() -> None:
    robot = wbc.load("simple_humanoid")
    gait, support = GaitParameters.for_robot(robot), SupportPolygon(robot)
    feet = Feet(Placement(0j, 0.0), Placement(complex(0.0, -gait.step_width), 0.0))
    state = GaitState(gait, feet, replace(gait, single_support=0.2))
    state.phase, state.duration, state.time, state.fast_share = Phase.SWING, 0.4, 0.36, 1.0
    toe = robot.soles[0].half_length
    assert edge_to_tip_over(state, complex(0.8 * toe), support) == 1 + 0j
    assert edge_to_tip_over(state, 0j, support) == 0j
    state.time = 0.2
    assert edge_to_tip_over(state, complex(0.8 * toe), support) == 0j
    state.time, state.fast_share = 0.4, 0.0
    assert edge_to_tip_over(state, complex(math.inf), support) == 0j
