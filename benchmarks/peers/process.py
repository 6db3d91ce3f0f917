"""Controls a worker process from the process of the comparison."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import threading
from pathlib import Path

import numpy as np

import wbc

BENCHMARKS = Path(__file__).resolve().parent.parent
TIMEOUT = 300.0  # s, for one reply


class LibraryFailedError(RuntimeError):
    """A library's process raised an error or died; the message holds its last output."""


class Worker:
    """One process of one library, which is idle between requests.

    Args:
        adapter: "module:class".
        python: interpreter of the library's environment; None for the one that runs this.
        scratch: folder for arrays and the log.
    """

    def __init__(self, adapter: str, python: Path | None, scratch: Path) -> None:
        self._out = scratch / "answer.npz"
        self._log = scratch / f"{adapter.replace(':', '-')}.log"
        paths = [str(BENCHMARKS)]
        if python is None:
            paths.append(str(Path(wbc.__file__).parents[1]))  # the same version as here
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths)}
        with self._log.open("w") as log:
            self._process = subprocess.Popen(
                [str(python or sys.executable), "-m", "peers.worker", adapter],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                text=True,
                env=environment,
                cwd=scratch,
            )

    def time(self, case: Path, passes: int) -> dict[str, np.ndarray]:
        """Return `cpu` and `wall`, ns, each of shape (passes, ticks).

        Raises:
            LibraryFailedError: the process raised, died, or took longer than `TIMEOUT`.
        """
        return self._ask(case=str(case), do="time", passes=passes)

    def solve(self, case: Path) -> dict[str, np.ndarray]:
        """Return the fields of `Outcome`, stacked over the ticks.

        Raises:
            LibraryFailedError: the process raised or died.
        """
        return self._ask(case=str(case), do="solve")

    def _ask(self, **request: object) -> dict[str, np.ndarray]:
        process = self._process
        assert process.stdin is not None
        assert process.stdout is not None
        watchdog = threading.Timer(TIMEOUT, process.kill)
        watchdog.start()
        try:
            process.stdin.write(json.dumps(request | {"out": str(self._out)}) + "\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except BrokenPipeError:
            line = ""
        finally:
            watchdog.cancel()
        if not line:
            process.wait()
            said = self._log.read_text().strip().splitlines()[-6:]
            raise LibraryFailedError(
                f"its process died (exit code {process.returncode})\n" + "\n".join(said)
            )
        answer = json.loads(line)
        if "error" in answer:
            raise LibraryFailedError(answer["error"])
        self.versions: dict[str, str] = answer["versions"]
        with np.load(self._out) as file:
            return {name: file[name] for name in file.files}

    def close(self) -> None:
        """End the process."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        try:
            self._process.wait(timeout=10.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
