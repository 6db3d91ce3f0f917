"""Log every tick of two runs, plot one, and find where they diverge."""

import tempfile
from dataclasses import replace
from pathlib import Path

import wbc
from wbc.log import FlightRecorder, LoggedRun, compare, plot

folder = Path(tempfile.gettempdir())
robot = wbc.load("g1")


def walk(name: str, gains: wbc.WalkerGains) -> LoggedRun:
    """Log one second of walking."""
    walker = wbc.Walker(robot, gains=gains)
    walker.velocity = (0.2, 0.0, 0.0)
    # The loop only copies to shared memory; another process writes. A crash leaves a readable file.
    with wbc.sim.Mujoco(robot) as plant, FlightRecorder(folder / f"{name}.mcap", robot) as log:
        wbc.run(walker, plant, duration=1.0, observers=[log])
    return LoggedRun.read(folder / f"{name}.mcap")


one = walk("one", wbc.WalkerGains())
other = walk("other", replace(wbc.WalkerGains(), trunk_kp=90.0))

print(f"{one.title}: {len(one)} ticks of {', '.join(one.log.topics)}")
print("pictures:", *plot(one, folder), sep="\n  ")

first = compare(one, other).first
assert first is not None
print(
    f"the runs diverge at {first.time:.3f} s in {first.label}: "
    f"{first.a:.4f} against {first.b:.4f} {first.unit}"
)
