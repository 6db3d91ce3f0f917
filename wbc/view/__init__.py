"""Observers for the eyes: a live page in the browser, and recordings that play offline.

Neither loads meshcat, a web server or a mesh into the loop's process.
"""

from wbc.view.errors import ViewerError
from wbc.view.live import Meshcat
from wbc.view.recording import Recording
from wbc.view.snapshot import Snapshot

__all__ = ["Meshcat", "Recording", "Snapshot", "ViewerError"]
