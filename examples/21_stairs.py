"""Climb a staircase and descend it: footsteps with heights, given in advance.

The stairs are those of Caron, Kheddar and Tempier, Stair climbing stabilization of the HRP-4
humanoid robot, ICRA 2019: four risers of 18.5 cm and one of 14.5 cm. High steps take time.
"""

from dataclasses import replace

import numpy as np

import wbc
from wbc.sim import Mujoco, Staircase
from wbc.telemetry import Footstep

robot = wbc.load("talos")
walker = wbc.Walker(robot)
walker.change_gait(replace(walker.gait, single_support=0.8, double_support=0.5))
stairs = Staircase(risers=(0.185,) * 4 + (0.145,), tread=0.25, landing=0.6, distance=0.18)

start, half = walker.feet.middle.real, 0.5 * walker.gait.step_width
steps = [
    Footstep(side, np.array([start + x, y, height]), 0.0)
    for x, height in stairs.footholds()  # both feet on each stair, twice on the landing
    for side, y in (("left", half), ("right", -half))
]
walker.follow(steps)

duration = 4.0 + len(steps) * walker.gait.step_duration
with Mujoco(robot, terrain=stairs, seed=0) as plant:
    print(wbc.run(walker, plant, duration))
