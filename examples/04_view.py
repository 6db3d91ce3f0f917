"""Walk in real time, show the robot in the browser, and save a recording that plays offline."""

import tempfile
from pathlib import Path

import wbc

robot = wbc.load("simple_humanoid")
walker = wbc.Walker(robot)
walker.velocity = (0.2, 0.0, 0.2)

# The viewer runs in its own process: the loop does not wait for a slow browser.
with wbc.sim.Mujoco(robot) as plant, wbc.view.Meshcat(robot) as viewer:  # prints its address
    recording = wbc.view.Recording(robot)
    report = wbc.run(walker, plant, duration=3.0, observers=[viewer, recording], real_time=True)

page = recording.save(Path(tempfile.gettempdir()) / "wbc_walk.html")
print(report.table())
print(f"open {page} in a browser")
