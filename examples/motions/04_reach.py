"""Reach: move the hands to positions in the stance frame; unreachable targets are reported.

The frame has its origin on the ground midway between the soles, x forward, y left, z up.
"""

import wbc
from wbc.motions import Reach
from wbc.trials import run_motions

robot = wbc.load("talos")
both = Reach(left=(0.45, 0.35, 1.2), right=(0.4, -0.3, 0.9))
too_far = Reach(left=(1.1, 0.3, 1.2))
report = run_motions(robot, [both, too_far], seed=1)
print(report.table())
