"""The flight recorder: every tick of a run in a file, and what to make of it afterwards.

Logs are MCAP files of ROS 2 messages, which Foxglove and PlotJuggler open.
"""

from wbc.log.errors import LogError
from wbc.log.recorder import FlightRecorder

__all__ = ["FlightRecorder", "LogError"]
