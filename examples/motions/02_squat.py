"""Squat by a share of the leg length. A squat that is too deep is refused, with the bound."""

import wbc
from wbc.errors import MotionError
from wbc.motions import Squat
from wbc.trials import run_motions

robot = wbc.load("g1")
print(run_motions(robot, [Squat(depth=10.0, frequency=0.5, times=2)]).table())

try:
    Squat(depth=40.0).check(robot)
except MotionError as refusal:
    print(f"\n{refusal}")
