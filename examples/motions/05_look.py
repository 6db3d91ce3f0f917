"""Look: head or trunk follow a point, depending on the joints of the robot."""

import wbc
from wbc.motions import Look
from wbc.trials import run_motions

for name in ("talos", "g1"):  # with neck joints and without
    report = run_motions(wbc.load(name), [Look(radius=0.3, seconds=4.0)])
    print(f"{name}: survived {report.duration_s:.1f} s; {' '.join(report.notes)}")
