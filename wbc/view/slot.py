"""A `Snapshot` as a fixed number of bytes: what crosses between processes.

Every part has its own place and a cap, so that writing one is a handful of
copies into views made beforehand: no allocation, no serialiser, microseconds.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from wbc.command import Status
from wbc.errors import StateError
from wbc.runtime.snapshot import Snapshot
from wbc.telemetry import PHASES, Footstep, Telemetry
from wbc.view.errors import ViewerError

logger = logging.getLogger(__name__)

CONTACTS = 8
SUPPORT = 16
FOOTSTEPS = 16
SWING = 64
TEXT = 240  # bytes

_STATUSES = tuple(Status)
_HEAD = 8


@dataclass(frozen=True)
class Layout:
    """Sizes of a slot, and the frames that contacts may be named after.

    Attributes:
        nq: size of a configuration.
        frames: names of the model's frames, in order.
    """

    nq: int
    frames: tuple[str, ...]

    @staticmethod
    def of(model: pin.Model) -> Layout:
        """The layout for a model."""
        return Layout(int(model.nq), tuple(frame.name for frame in model.frames))

    @property
    def nbytes(self) -> int:
        """Size of one slot."""
        numbers = _HEAD + 12 + self.nq + 7 * CONTACTS + 3 * SUPPORT + 5 * FOOTSTEPS + 3 * SWING
        return 8 * numbers + TEXT


class Slot:
    """One snapshot's place in a buffer.

    Args:
        layout: what goes where.
        buffer: at least `layout.nbytes` writable bytes.
    """

    def __init__(self, layout: Layout, buffer: memoryview | bytearray) -> None:
        self.layout = layout
        self._index = {name: i for i, name in reversed(list(enumerate(layout.frames)))}
        self._unknown: set[str] = set()
        end = layout.nbytes - TEXT
        numbers = np.frombuffer(buffer, dtype=np.float64, count=end // 8)
        self._text = memoryview(buffer)[end : end + TEXT].cast("B")
        sizes = (_HEAD, 3, 3, 3, 3, layout.nq, 7 * CONTACTS, 3 * SUPPORT, 5 * FOOTSTEPS, 3 * SWING)
        parts = np.split(numbers, np.cumsum(sizes)[:-1])
        self._head, self._com, self._dcm, self._reference, self._zmp, self._q = parts[:6]
        self._contacts = parts[6].reshape(CONTACTS, 7)
        self._support = parts[7].reshape(SUPPORT, 3)
        self._footsteps = parts[8].reshape(FOOTSTEPS, 5)
        self._swing = parts[9].reshape(SWING, 3)

    def write(self, snapshot: Snapshot) -> None:
        """Copy a snapshot into the slot. What exceeds a cap is left out.

        Raises:
            StateError: `snapshot.q` has the wrong size.
            ViewerError: another part has the wrong shape.
        """
        if np.shape(snapshot.q) != self._q.shape:
            raise StateError(
                f"snapshot.q has shape {np.shape(snapshot.q)}, the model needs {self._q.shape}"
            )
        telemetry = snapshot.telemetry
        try:
            self._q[:] = snapshot.q
            self._com[:] = telemetry.com
            self._dcm[:] = telemetry.dcm
            self._reference[:] = telemetry.dcm_reference
            self._zmp[:] = telemetry.zmp
            phase = PHASES.index(telemetry.phase) if telemetry.phase in PHASES else 0
            text = snapshot.text.encode("utf-8", "replace")[:TEXT]
            self._text[: len(text)] = text
            self._head[:] = (
                snapshot.time,
                _STATUSES.index(snapshot.status),
                phase,
                self._write_contacts(snapshot),
                _copy_rows(self._support, telemetry.support),
                self._write_footsteps(telemetry.footsteps),
                _copy_rows(self._swing, telemetry.swing_path),
                len(text),
            )
        except (ValueError, TypeError) as error:
            raise ViewerError(
                f"the snapshot at {snapshot.time} s cannot be shown: {error}; "
                "see wbc.view.Snapshot and wbc.telemetry.Telemetry for the shapes"
            ) from error

    def _write_contacts(self, snapshot: Snapshot) -> int:
        count = 0
        for name, wrench in snapshot.wrenches.items():
            index = self._index.get(name)
            if index is None:
                self._complain(name)
                continue
            if count == CONTACTS:
                break
            row = self._contacts[count]
            row[0] = index
            row[1:] = wrench
            count += 1
        return count

    def _write_footsteps(self, footsteps: tuple[Footstep, ...]) -> int:
        footsteps = footsteps[:FOOTSTEPS]
        rows = self._footsteps
        for i, step in enumerate(footsteps):
            rows[i, 0] = step.side == "right"
            rows[i, 1:4] = step.position
            rows[i, 4] = step.yaw
        return len(footsteps)

    def _complain(self, name: str) -> None:
        if name not in self._unknown:
            self._unknown.add(name)
            logger.warning(
                "contact '%s' is not a frame of the model: its force cannot be drawn; "
                "name contacts after frames",
                name,
            )

    def read(self) -> Snapshot:
        """The snapshot in the slot, as arrays of its own."""
        time, status, phase, contacts, support, steps, swing, text = self._head.tolist()
        return Snapshot(
            time=time,
            q=self._q.copy(),
            wrenches={
                self.layout.frames[int(row[0])]: row[1:].copy()
                for row in self._contacts[: int(contacts)]
            },
            telemetry=Telemetry(
                com=self._com.copy(),
                dcm=self._dcm.copy(),
                dcm_reference=self._reference.copy(),
                zmp=self._zmp.copy(),
                support=self._support[: int(support)].copy(),
                footsteps=tuple(
                    Footstep("right" if row[0] else "left", row[1:4].copy(), float(row[4]))
                    for row in self._footsteps[: int(steps)]
                ),
                swing_path=self._swing[: int(swing)].copy(),
                phase=PHASES[int(phase)],
            ),
            status=_STATUSES[int(status)],
            text=bytes(self._text[: int(text)]).decode("utf-8", "ignore"),
        )


def _copy_rows(rows: np.ndarray, points: np.ndarray) -> int:
    count = min(len(points), len(rows))
    if count:
        rows[:count] = points[:count]
    return count
