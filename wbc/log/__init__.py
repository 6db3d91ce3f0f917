"""The flight recorder: every tick of a run in a file, and what to make of it afterwards.

Logs are MCAP files of ROS 2 messages, which Foxglove and PlotJuggler open.
"""

from wbc.log.diff import Difference, Parting, compare
from wbc.log.errors import LogError
from wbc.log.pictures import plot
from wbc.log.reader import Log
from wbc.log.recorder import FlightRecorder
from wbc.log.recovery import repair
from wbc.log.robot import robot_of
from wbc.log.run import LoggedRun

__all__ = [
    "Difference",
    "FlightRecorder",
    "Log",
    "LogError",
    "LoggedRun",
    "Parting",
    "compare",
    "plot",
    "repair",
    "robot_of",
]
