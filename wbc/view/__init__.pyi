"""The public names of `wbc.view`, each once."""

import wbc.runtime.snapshot

from .errors import ViewerError as ViewerError
from .meshcat import Meshcat as Meshcat
from .recording import Recording as Recording
from .replay import Replay as Replay
from .timeline import Timeline as Timeline
from .timeline import TimeSeries as TimeSeries
from .video import Video as Video
from .video_format import VideoFormat as VideoFormat

Snapshot = wbc.runtime.snapshot.Snapshot
