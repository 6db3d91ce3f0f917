"""Processes as Linux describes them in `/proc`."""

from __future__ import annotations

import os
from pathlib import Path


def child_processes(pid: int) -> dict[str, int]:
    """Return the process ids of the children that run modules of wbc, by module name."""
    found = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parent = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
            arguments = (folder / "cmdline").read_bytes().decode(errors="replace").split("\0")
        except (OSError, ValueError):  # it has ended meanwhile
            continue
        if parent == pid and "-m" in arguments:
            found[arguments[arguments.index("-m") + 1]] = int(folder.name)
    return found


def is_running(pid: int) -> bool:
    """Return whether a process runs; one that has ended but was not waited for does not."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def private_memory(pid: int) -> float:
    """Return the memory that only this process has, MB; NaN if it has ended.

    Memory that processes share, such as the ring of ticks, is not counted: it has a fixed size.
    """
    try:
        text = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return float("nan")
    fields = dict(line.split(":", 1) for line in text.splitlines() if ":" in line)
    kilobytes = fields.get("RssAnon", "nan kB").split()[0]
    return float(kilobytes) / 1024.0


def descriptors(pid: int) -> int:
    """Return the number of open file descriptors of a process; 0 if it has ended."""
    try:
        return len(os.listdir(f"/proc/{pid}/fd"))
    except OSError:
        return 0
