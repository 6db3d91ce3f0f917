"""The page of a recording, a file that plays offline."""

from __future__ import annotations

import base64
import gzip
import json
import struct
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from wbc.runtime.snapshot import Snapshot
from wbc.view.errors import ViewerError
from wbc.view.page_text import caption, offline_page, viewer_scripts
from wbc.view.scene import Scene

if TYPE_CHECKING:
    from wbc.robot import Robot


def recorded_page(robot: Robot, boxes: np.ndarray, frames: Sequence[Snapshot]) -> str:
    """Return a page that shows snapshots in succession.

    It contains the commands that create the objects, each preceded by its length, and the poses of
    all nodes: by node, number and frame, an order in which constant numbers compress well.

    Args:
        robot: Robot to show.
        boxes: Terrain as boxes: see `wbc.sim.Terrain`.
        frames: Snapshots, at least one, at increasing times.

    Raises:
        ViewerError: No snapshot has a finite configuration.
    """
    scene = Scene(robot, boxes)
    shown = [(caption(frame), scene.poses.copy()) for frame in frames if scene.update(frame)]
    if not shown:
        raise ViewerError("nothing was recorded: show() at least one snapshot before save()")
    captions, poses = zip(*shown, strict=True)
    recording = {
        "scale": scene.proportions.top,
        "paths": scene.paths,
        "smooth": [node.smooth for node in scene.nodes],
        "captions": captions,
    }
    commands = b"".join(struct.pack("<I", len(c)) + c for c in scene.commands())
    data = {
        "recording": json.dumps(recording, separators=(",", ":")).replace("</", "<\\/"),
        "objects": _packed(commands),
        "poses": _packed(np.stack(poses, axis=-1).round(5).astype("<f4").tobytes()),
    }
    return offline_page(robot.name, data, viewer_scripts("player.js", "recorded.js"))


def _packed(data: bytes) -> str:
    return base64.b64encode(gzip.compress(data, compresslevel=6)).decode("ascii")
