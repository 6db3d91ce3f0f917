"""Bow: waist and hips share the angle, the centre of mass stays over the feet."""

import wbc
from wbc.motions import Bow
from wbc.trials import run_motions

robot = wbc.load("talos")
print(run_motions(robot, [Bow(angle=30.0)]).table())
