"""Declare your own quantity: it appears in log, plots, live page and ROS 2 under its name."""

import tempfile
from pathlib import Path

import wbc
from wbc.log import FlightRecorder, LoggedRun

power = wbc.Quantity(
    "joint_power",
    lambda tick: tick.command.tau * tick.estimate.state.v[6:],
    "mechanical power of each joint",
    unit="W",
    size="na",
)

robot = wbc.load("simple_humanoid")
walker = wbc.Walker(robot)
walker.velocity = (0.1, 0.0, 0.0)
path = Path(tempfile.gettempdir()) / "own_quantity.mcap"

with wbc.sim.Mujoco(robot) as plant, FlightRecorder(path, robot) as log:
    wbc.run(walker, plant, duration=1.0, observers=[log], quantities=[power])

# `wbc plot FILE --signal joint_power` draws it over time.
run = LoggedRun.read(path)
peaks = abs(run["joint_power"]).max(axis=0)
joint = int(peaks.argmax())
print(f"largest power: {run.quantities['joint_power'].label(joint)}: {peaks[joint]:.1f}")
