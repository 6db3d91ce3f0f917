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
from processtools import wait_until
from rostools import environment, restore_sigint, unused_domain

from wbc.process import ChildProcess, RingReader, SharedRing
from wbc.runtime.schema import Schema
from wbc.runtime.stream import StreamLink


def write(ring, value):
    ring.rows[ring.begin()] = value
    ring.publish()


def test_a_ring_delivers_complete_records_in_order():
    ring = SharedRing(2, capacity=16)
    reader = RingReader(SharedRing(2, capacity=16, descriptor=os.dup(ring.descriptor)), first=0)
    for i in range(5):
        write(ring, i)
    ring.rows[ring.begin()] = 5  # not published
    assert reader.take(100).tolist() == [[i, i] for i in range(5)]
    assert len(reader.take(100)) == 0


def test_a_ring_drops_the_oldest_for_a_slow_reader_and_counts_them():
    ring = SharedRing(1, capacity=8)
    reader = RingReader(ring)
    taken = []
    for burst in (5, 8, 3, 20, 1):
        for _ in range(burst):
            write(ring, ring.published)
        while len(rows := reader.take(3)):
            taken += rows[:, 0].tolist()
    assert taken == [*range(16), *range(28, 37)]
    assert reader.lost == 12


def test_the_latest_record_of_a_ring_is_returned_once():
    ring = SharedRing(1, capacity=4)
    reader = RingReader(ring)
    assert reader.latest() is None
    for i in range(6):
        write(ring, i)
    assert reader.latest() == [5.0]
    assert reader.latest() is None


def test_a_child_gets_a_descriptor_with_a_message(tmp_path):
    module = tmp_path / "reads_a_ring.py"
    module.write_text(
        "from wbc.process import ParentConnection, SharedRing\n"
        "parent = ParentConnection()\n"
        "ring = SharedRing(1, 4, descriptor=parent.config.descriptor)\n"
        "parent.reply({'value': float(ring.rows[0, 0])})\n"
    )
    ring = SharedRing(1, capacity=4)
    write(ring, 7.0)
    sys.path.insert(0, str(tmp_path))
    try:
        child = ChildProcess("reads_a_ring")
        child.send(StreamLink(Schema(()), 4, 0), ring.descriptor)
        reply = child._connection.recv()
        child.close()
    finally:
        sys.path.remove(str(tmp_path))
    assert reply == {"value": 7.0}


def test_a_child_goes_on_listening_after_a_message_that_it_cannot_handle(tmp_path, capfd):
    module, handled = tmp_path / "listens.py", tmp_path / "handled"
    module.write_text(
        "from pathlib import Path\n"
        "from wbc.process import ParentConnection\n"
        "parent = ParentConnection()\n"
        "parent.reply({'ready': True})\n"
        "parent.listen(lambda path: Path(path).touch())\n"
        "while not parent.gone:\n"
        "    parent.wait(1.0)\n"
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(tmp_path))
        child = ChildProcess("listens")
    child.configure(None)
    child.send(3)
    child.send(str(handled))
    wait_until(handled.exists)
    child.close()
    assert "the parent's message int could not be handled" in capfd.readouterr().err


@pytest.mark.parametrize("said", [b"", (1000).to_bytes(4, "big") + b"half"])
@pytest.mark.parametrize(
    "module", ["view.server", "log.writer", "live.server", "ros.bridge.server"]
)
def test_a_child_whose_parent_dies_while_configuring_it_ends_silently(module, said):
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
    [
        pytest.param(signal.SIGKILL, -signal.SIGKILL, True, id="killed at its first child"),
        pytest.param(
            signal.SIGINT, 130, False, id="interrupted at its last", marks=pytest.mark.slow
        ),
    ],
)
def test_a_parent_that_ends_while_starting_a_child_leaves_no_child_and_no_traceback(
    tmp_path, sign, code, early
):
    for package in ("mujoco", "cyclonedds", "mcap"):
        pytest.importorskip(package)
    running = []
    for number, command in commands(tmp_path):
        process = subprocess.Popen(
            [sys.executable, "-m", "wbc", *command, "--robot", "simple_humanoid"],
            env=environment(unused_domain()),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            preexec_fn=restore_sigint,
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
