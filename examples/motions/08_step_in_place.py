"""Step in place: the walker's own steps, onto the places where the feet are."""

import wbc
from wbc.motions import StepInPlace
from wbc.trials import run_motions

robot = wbc.load("simple_humanoid")
report = run_motions(robot, [StepInPlace(steps=4)])
print(report.table())
