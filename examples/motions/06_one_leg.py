"""Stand on one leg, withstand a light push on the torso, and put the foot down."""

import wbc
from wbc.motions import OneLeg
from wbc.trials import run_motions

robot = wbc.load("g1")
report = run_motions(robot, [OneLeg(leg="left", hold=3.0, impulse=0.05, towards=90.0)])
print(report.table())
