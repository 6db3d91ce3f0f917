"""The configuration of the live page's server."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from wbc.teleop import ChannelConfig
from wbc.view.config import ViewerConfig


@dataclass(frozen=True, eq=False)
class LiveServerConfig(ViewerConfig):
    """The configuration of the live page's server; `rate` is that of frames and status, Hz.

    Attributes:
        channel: Channel of the commands.
        host: Address to listen on.
        token: What the address of the page must contain; empty for nothing.
        dt: Control period, s.
        events: File descriptor of the queue of events.
        uploads: Folder for the files that pages send, and that are saved for them.
        notice: What the pages show at first; empty for nothing.
    """

    channel: ChannelConfig
    host: str
    token: str
    dt: float
    events: int
    uploads: Path
    notice: str
