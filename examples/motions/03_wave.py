"""Wave with both arms, standing and then walking: the walker controls the legs."""

import wbc
from wbc.motions import Wave
from wbc.trials import run_motions

robot = wbc.load("simple_humanoid")
report = run_motions(robot, [Wave(seconds=2.0), Wave(seconds=3.0, walk=0.3)])
print(report.table())
