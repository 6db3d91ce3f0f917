"""The page of a recording, a file that plays offline."""

from __future__ import annotations

import base64
import gzip
import json
import struct
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from wbc.view.errors import ViewerError
from wbc.view.page_text import caption, offline_page, viewer_scripts
from wbc.view.scene import Scene

if TYPE_CHECKING:
    from wbc.view.recording import Recording


def recorded_page(recording: Recording) -> str:
    """Return a page that shows the snapshots of a recording in succession.

    It contains the commands that create the objects, each preceded by its length, and the poses of
    all nodes: by node, number and frame, an order in which constant numbers compress well.

    Args:
        recording: A recording with at least one frame.

    Raises:
        ViewerError: No snapshot has a finite configuration.
    """
    scene = Scene(recording.robot, recording.boxes)
    shown = [
        (round(time, 4), caption(frame), scene.poses.copy())
        for time, frame in zip(recording.times, recording.frames, strict=True)
        if scene.update(frame)
    ]
    if not shown:
        raise ViewerError("nothing was recorded: show() at least one snapshot before save()")
    times, captions, poses = zip(*shown, strict=True)
    content = {
        "scale": scene.proportions.top,
        "paths": scene.paths,
        "smooth": [node.smooth for node in scene.nodes],
        "times": times,
        "captions": captions,
        "markers": [asdict(marker) for marker in recording.markers],
    }
    commands = b"".join(struct.pack("<I", len(c)) + c for c in scene.commands())
    data = {
        "recording": json.dumps(content, separators=(",", ":")).replace("</", "<\\/"),
        "objects": _packed(commands),
        "poses": _packed(np.stack(poses, axis=-1).round(5).astype("<f4").tobytes()),
    }
    files = viewer_scripts("player.js", "software.js", "recorded.js")
    return offline_page(recording.robot.name, data, files)


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, compresslevel=6)).decode("ascii")
