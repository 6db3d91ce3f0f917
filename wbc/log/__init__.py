"""Logs: the flight recorder of every tick, and tools that read, plot and compare runs.

Logs are MCAP files of ROS 2 messages, which Foxglove and PlotJuggler open.
"""

from wbc.log.diff import Difference, Divergence, compare
from wbc.log.errors import LogError
from wbc.log.logged_robot import logged_robot
from wbc.log.logged_tick import LoggedTick
from wbc.log.plots import plot
from wbc.log.reader import Log
from wbc.log.recorder import FlightRecorder
from wbc.log.recovery import RepairedLog, repair
from wbc.log.run import LoggedRun
from wbc.log.time_span import TimeSpan
from wbc.log.timeline import LoggedTimeline
from wbc.log.topic_table import TopicTable

__all__ = [
    "Difference",
    "Divergence",
    "FlightRecorder",
    "Log",
    "LogError",
    "LoggedRun",
    "LoggedTick",
    "LoggedTimeline",
    "RepairedLog",
    "TimeSpan",
    "TopicTable",
    "compare",
    "logged_robot",
    "plot",
    "repair",
]
