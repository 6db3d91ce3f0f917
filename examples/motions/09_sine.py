"""Move fifteen joints on sine waves: the robot falls in open loop, but not with balance control."""

import wbc
from wbc.motions import Sine
from wbc.trials import run_motions

robot = wbc.load("simple_humanoid")
open_loop = run_motions(robot, [Sine(open_loop=True, seconds=6.3)])
print(f"open loop: {open_loop.fell_why or 'stands'} after {open_loop.duration_s:.1f} s")
print(run_motions(robot, [Sine(seconds=6.3)]).table())
