"""Step in place: the walker steps onto the current positions of the feet."""

import wbc
from wbc.motions import StepInPlace
from wbc.trials import run_motions

robot = wbc.load("simple_humanoid")
report = run_motions(robot, [StepInPlace(steps=4)])
print(report.table())
