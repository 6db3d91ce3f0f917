"""Sway: the centre of mass on a circle, then on a figure of eight.

`run_motions` plays motions in MuJoCo with noisy sensors, from standing to standing, and
compares them with the true state.
"""

import wbc
from wbc.motions import Sway
from wbc.trials import run_motions

robot = wbc.load("talos")
report = run_motions(robot, [Sway(size=0.04, rounds=2), Sway(shape="eight", rounds=2)])
print(report.table())
print(f"the CoM was {report.com_error_rms_mm:.1f} mm rms from its reference")
