"""Pauses of the machine itself: what no program on it could have avoided."""

from __future__ import annotations

import os
import subprocess
import sys
import time

_PRIORITY = 90  # SCHED_FIFO, above all that is measured
_PERIOD = 0.001  # s


class MachinePauses:
    """The longest time by which a process of the highest priority wakes up late, on each core.

    One process per core sleeps for a millisecond, again and again. What delays it is the hypervisor
    or the kernel, not other programs.

    Attributes:
        longest: s; 0 where the priority is not granted. Set at the end of the context.
    """

    def __init__(self) -> None:
        self.longest = 0.0
        self._processes: list[subprocess.Popen[str]] = []

    def __enter__(self) -> MachinePauses:
        for core in sorted(os.sched_getaffinity(0)):
            command = [sys.executable, __file__, str(core)]
            self._processes.append(
                subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
            )
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._processes:
            process.terminate()
        outputs = [process.communicate()[0] for process in self._processes]
        self.longest = max(float(line) for output in outputs for line in output.split())


def _watch(core: int) -> None:
    os.sched_setaffinity(0, {core})
    print(0.0, flush=True)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except PermissionError:
        time.sleep(1e9)
    longest = 0.0
    while True:
        begin = time.perf_counter()
        time.sleep(_PERIOD)
        late = time.perf_counter() - begin - _PERIOD
        if late > longest:
            longest = late
            print(longest, flush=True)


if __name__ == "__main__":
    _watch(int(sys.argv[1]))
