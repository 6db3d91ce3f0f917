"""Writes a log of ticks that are already there, e.g. the last minutes of a live session."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from wbc.atomic_file import replacing
from wbc.log.errors import LogError, require_packages
from wbc.robot import Robot
from wbc.runtime.event_queue import NumberedEvent
from wbc.runtime.schema import Schema, columns_to_json
from wbc.topics import BatchMaker, StreamTopics

_BATCH = 500  # ticks per chunk


def write_log(
    path: Path,
    robot: Robot,
    schema: Schema,
    records: np.ndarray,
    stamps: np.ndarray,
    *,
    events: Sequence[NumberedEvent] = (),
    boxes: np.ndarray | None = None,
) -> None:
    """Write a log like that of a `FlightRecorder`.

    Args:
        path: Path of the file.
        robot: Robot of the ticks.
        schema: Schema of the records.
        records: Records of the ticks, shape (n,).
        stamps: Their times, ns, shape (n,).
        events: What was done to the robot meanwhile, and what happened to it.
        boxes: Terrain as boxes, see `wbc.sim.Terrain`.

    Raises:
        LogError: There is no tick, or the file cannot be written.
        MissingExtra: `mcap` or `rosbags` is not installed.
    """
    require_packages()
    from wbc.log.event_log import EventLog
    from wbc.log.mcapfile import McapFile
    from wbc.log.metadata import STRETCH, Metadata, versions
    from wbc.log.robot_info import RobotInfo

    if not len(records):
        raise LogError(f"there is no tick to write to {path}")
    batches, topics = BatchMaker(robot), StreamTopics(robot)
    topics.attach(schema)
    files = {
        "robot.json": RobotInfo.of(robot).to_json(),
        "quantities.json": columns_to_json(schema.columns),
        "terrain.json": json.dumps({"boxes": [] if boxes is None else boxes.tolist()}),
    }
    waiting = list(events)
    try:
        with replacing(path) as partial, contextlib.closing(McapFile(partial)) as file:
            file.add(Metadata({"versions": versions()}, files))
            log = EventLog(file, lambda: [waiting.pop(0) for _ in range(len(waiting))])
            for start in range(0, len(records), _BATCH):
                rows = slice(start, start + _BATCH)
                batch = batches.batch(records[rows], stamps[rows])
                file.write(batch, topics.topics_of(records[rows]))
                log.on_ticks(records[rows], stamps[rows])
                log.advance()
                file.commit()
            log.finish()
            span = {"from_ns": str(stamps[0]), "to_ns": str(stamps[-1])}
            file.add(Metadata({"log": {"ticks": str(len(records)), "dropped": "0"}}))
            file.add(Metadata({STRETCH: span}))
            file.finish()
    except OSError as error:
        raise LogError(f"cannot write {path}: {error.strerror}") from error
