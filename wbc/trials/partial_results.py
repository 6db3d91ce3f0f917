"""Finished trials of a grid that still runs: a file that only grows."""

from __future__ import annotations

import fcntl
import json
import os
import shutil
from dataclasses import asdict
from pathlib import Path
from typing import Any

from wbc.closeable import Closeable
from wbc.trials.errors import ResultsError
from wbc.trials.provenance import Provenance
from wbc.trials.result import TrialResult

_ROW_SIZE = 2000  # bytes of disk per result, partial and final file together, rounded up
_RESERVE = 10_000_000  # bytes that the disk has to have beside


class PartialResults(Closeable):
    """Appends each result as it comes; a line that was cut off is left out when read.

    The first line states the versions of the software, every other one is a result in JSON.

    Args:
        path: path of the file.
        provenance: versions of the software that computes the results.
        expected: number of results that are expected.

    Attributes:
        path: path of the file.
        provenance: versions of the software.
        finished: results that an earlier run has left, by key.

    Raises:
        ResultsError: the file cannot be written, the disk has not enough space, another run writes
            it, or it has results of other software.
    """

    def __init__(self, path: Path, provenance: Provenance, expected: int) -> None:
        self.path, self.provenance = path, provenance
        self.finished: dict[str, TrialResult] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("a+b", buffering=0)
        except OSError as error:
            raise ResultsError(f"cannot write {path}: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise ResultsError(
                f"another run writes {path}; wait for its end, or stop it"
            ) from error
        try:
            self._begin(provenance)
            free, needed = shutil.disk_usage(path.parent).free, expected * _ROW_SIZE + _RESERVE
            if free < needed:
                raise ResultsError(
                    f"{path.parent.resolve()} has {free / 1e6:.0f} MB left; the results may need "
                    f"{needed / 1e6:.0f} MB"
                )
        except BaseException:
            self._file.close()
            raise

    def _begin(self, provenance: Provenance) -> None:
        self._file.seek(0)
        content = self._file.read()
        complete = content.rfind(b"\n") + 1
        if complete < len(content):
            self._file.truncate(complete)  # the end of a line that was cut off
        lines = content[:complete].splitlines()
        if not lines:
            self._append({"versions": asdict(provenance)})
            return
        try:
            earlier = Provenance(**json.loads(lines[0])["versions"])
            rows = [TrialResult(**json.loads(line)) for line in lines[1:]]
        except (ValueError, KeyError, TypeError) as error:
            raise ResultsError(
                f"{self.path} does not contain results of this version of wbc trials; delete it "
                "or give another output"
            ) from error
        differences = earlier.differences(provenance)
        if differences:
            raise ResultsError(
                f"{self.path} was begun with other software: {', '.join(differences)}; give "
                "another output, or --restart to discard its results"
            )
        self.finished = {row.key: row for row in rows}

    def add(self, row: TrialResult) -> None:
        """Append a result; it is on disk when this returns.

        Raises:
            ResultsError: it cannot be written, e.g. because the disk is full.
        """
        self._append(asdict(row))
        self.finished[row.key] = row

    def _append(self, content: dict[str, Any]) -> None:
        line = json.dumps(content).encode() + b"\n"
        try:
            written = 0
            while written < len(line):  # a full disk may take a part
                written += self._file.write(line[written:])
            os.fsync(self._file.fileno())
        except OSError as error:
            raise ResultsError(
                f"cannot write {self.path}: {error.strerror}; it has {len(self.finished)} results"
            ) from error

    def close(self) -> None:
        """Close the file."""
        self._file.close()
