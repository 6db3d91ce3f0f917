"""Processes of our own beside the loop's: what they share, and how they end."""

import contextlib
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from rostools import environment, hear_interrupts, new_domain

from wbc.process.records import SLOTS, RecordRing


def test_a_ring_gives_records_in_order_and_never_half_of_one():
    ring = RecordRing(2)
    reader = RecordRing(2, os.dup(ring.descriptor))
    for i in range(5):
        ring.begin()[:] = i
        ring.publish()
    assert [r.tolist() for r in reader.read()] == [[i, i] for i in range(5)]
    ring.begin()[:] = 5  # not published
    assert list(reader.read()) == []


def test_a_ring_drops_the_oldest_for_a_slow_reader():
    ring = RecordRing(1)
    reader = RecordRing(1, os.dup(ring.descriptor))
    for i in range(3 * SLOTS):
        ring.begin()[:] = i
        ring.publish()
    got = [int(r[0]) for r in reader.read()]
    assert got == list(range(3 * SLOTS - len(got), 3 * SLOTS))
    assert len(got) >= SLOTS // 2


def test_who_comes_late_to_a_ring_gets_the_latest():
    ring = RecordRing(1, slots=4)
    for i in range(6):
        ring.begin()[:] = i
        ring.publish()
    reader = RecordRing(1, os.dup(ring.descriptor), slots=4)
    assert [int(r[0]) for r in reader.read()] == [4, 5]


@pytest.mark.parametrize("said", [b"", (1 << 40).to_bytes(8, "little") + b"half"])
@pytest.mark.parametrize(
    "module", ["view.server", "log.writer", "live.server", "ros.bridge.server"]
)
def test_a_child_whose_parent_dies_before_its_order_is_whole_ends_silently(module, said):
    if module.startswith("ros"):
        pytest.importorskip("cyclonedds")
    ours, theirs = socket.socketpair()
    ours.sendall(said)
    ours.close()
    with theirs:
        command = [sys.executable, "-m", f"wbc.{module}"]
        done = subprocess.run(command, stdin=theirs.fileno(), capture_output=True, timeout=60)
    assert (done.returncode, done.stdout, done.stderr) == (0, b"", b"")


def children(pid):
    """Of our own among a process's children."""
    found = []
    with contextlib.suppress(OSError):
        for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split():
            command = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
            found += [part for part in command if part.startswith(b"wbc.")]
    return found


def commands(folder):
    log = ("--log", str(folder / "run.mcap"))
    yield 2, ("walk", "--real-time", *log)
    yield 1, ("live", "--port", "0")
    yield 3, ("ros2", "walk", "--view", *log)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks for children in /proc")
@pytest.mark.parametrize(
    ("sign", "code", "early"),
    [(signal.SIGKILL, -signal.SIGKILL, True), (signal.SIGINT, 130, False)],
    ids=["killed at its first child", "interrupted at its last"],
)
def test_whoever_ends_while_it_starts_leaves_no_child_and_no_traceback(tmp_path, sign, code, early):
    for package in ("mujoco", "cyclonedds", "zstandard"):
        pytest.importorskip(package)
    running = []
    for number, command in commands(tmp_path):
        process = subprocess.Popen(
            [sys.executable, "-m", "wbc", *command, "--robot", "simple_humanoid"],
            env=environment(new_domain()),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=hear_interrupts,
        )
        running.append((process, 1 if early else number))
    waiting = list(running)
    deadline = time.monotonic() + 60.0
    while waiting and time.monotonic() < deadline:
        for one in tuple(waiting):
            process, number = one
            if process.poll() is not None or len(children(process.pid)) >= number:
                process.send_signal(sign)
                waiting.remove(one)
        time.sleep(0.002)
    assert not waiting
    for process, _ in running:
        # Its children have the same standard error: it ends with the last of them.
        _, said = process.communicate(timeout=60.0)
        assert b"Traceback" not in said, said.decode()
        assert process.returncode == code
