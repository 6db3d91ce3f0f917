"""Viewers: a live page in the browser, recordings that play offline, replays and videos.

The process of the control loop loads neither meshcat, nor a web server, nor meshes.
"""

from wbc.runtime.snapshot import Snapshot
from wbc.view.errors import ViewerError
from wbc.view.meshcat import Meshcat
from wbc.view.recording import Recording
from wbc.view.replay import Replay
from wbc.view.timeline import Timeline, TimeSeries
from wbc.view.video import Video

__all__ = [
    "Meshcat",
    "Recording",
    "Replay",
    "Snapshot",
    "TimeSeries",
    "Timeline",
    "Video",
    "ViewerError",
]
