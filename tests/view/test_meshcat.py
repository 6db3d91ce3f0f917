"""The viewer's process never slows, stops or outlives the loop."""

import json
import logging
import os
import signal
import socket
import statistics
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import numpy as np
import pytest
from processtools import gone, wait_until

import wbc
from wbc.errors import StateError
from wbc.runtime.event import COMMAND, FALL, RESET, RunEvent
from wbc.runtime.stream import TickStream
from wbc.view import Meshcat, Recording, Snapshot, ViewerError
from wbc.view.web import listen

ROOT = Path(wbc.__file__).parent.parent


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def viewer(robot):
    with Meshcat(robot, port=0, announce=False) as viewer:
        yield viewer


def python(code, **options):
    env = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", code]
    return subprocess.run(command, env=env, capture_output=True, text=True, timeout=60, **options)


def test_the_loops_process_loads_neither_meshcat_nor_a_server():
    code = """
import sys, wbc
from wbc.view import Meshcat, Recording, Snapshot
robot = wbc.load("simple_humanoid")
with Meshcat(robot, port=0) as viewer:
    recording = Recording(robot)
    for observer in (viewer, recording):
        observer.show(Snapshot(0.0, robot.q_nominal))
print(sorted({"meshcat", "mujoco", "tornado", "umsgpack", "zmq"} & set(sys.modules)))
"""
    result = python(code)  # no `__main__` guard, and none is needed
    assert result.stderr == ""
    assert result.stdout.splitlines()[-1] == "[]"


def test_viewer_serves_its_page(viewer):
    with urllib.request.urlopen(viewer.url) as answer:
        assert "simple_humanoid" in answer.read().decode()


def test_page_is_served_to_this_machine_only(viewer):
    port = int(viewer.url.split(":")[2].split("/")[0])
    # Another address of the loopback interface: taken only by servers that listen on all.
    with pytest.raises(OSError), socket.create_connection(("127.0.0.2", port), timeout=1):  # noqa: PT011
        pass
    # A page of another site whose name was made to point here.
    request = urllib.request.Request(viewer.url, headers={"Host": "example.org"})
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(request)


def test_closing_the_viewer_ends_its_process(robot):
    viewer = Meshcat(robot, port=0, announce=False)
    viewer.show(Snapshot(0.0, robot.q_nominal))
    start = time.monotonic()
    viewer.close()
    assert time.monotonic() - start < 3.0
    assert not viewer.alive
    viewer.close()  # again is no harm
    viewer.show(Snapshot(0.1, robot.q_nominal))


def test_two_viewers_live_side_by_side(robot, viewer):
    with Meshcat(robot, announce=False) as other:
        assert other.url != viewer.url


def test_a_port_in_use_is_refused_by_number(robot):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(ViewerError, match=f"port {port} is in use"):
            Meshcat(robot, port=port)


def test_an_address_of_another_machine_is_not_called_a_port_in_use():
    with pytest.raises(ViewerError, match=r"cannot listen on 203\.0\.113\.1, port 7000: "):
        listen([], None, "203.0.113.1")


@pytest.mark.parametrize("make", [Meshcat, Recording])
def test_a_rate_must_be_positive(robot, make):
    with pytest.raises(ViewerError, match="rate is 0"):
        make(robot, rate=0.0)


def test_an_ended_viewer_does_not_affect_the_loop_and_is_reported_once(robot, viewer, caplog):
    os.kill(viewer.pid, signal.SIGKILL)
    wait_until(lambda: not viewer.alive)
    with caplog.at_level(logging.WARNING):
        for k in range(100):
            viewer.show(Snapshot(0.01 * k, robot.q_nominal))
    said = [r for r in caplog.records if "viewer's process has ended" in r.getMessage()]
    assert len(said) == 1


def test_a_stopped_viewer_never_blocks_the_loop(robot, viewer):
    os.kill(viewer.pid, signal.SIGSTOP)
    try:
        spent = []
        for k in range(2000):
            start = time.perf_counter()
            viewer.show(Snapshot(0.002 * k, robot.q_nominal))
            spent.append(time.perf_counter() - start)
        assert statistics.median(spent) < 200e-6
        assert sum(spent) < 2.0
        start = time.monotonic()
        viewer.close()
        assert time.monotonic() - start < 5.0
    finally:
        if not gone(viewer.pid):
            os.kill(viewer.pid, signal.SIGCONT)
    assert gone(viewer.pid)


def test_the_viewer_ends_with_a_parent_that_is_killed():
    code = """
import os, signal, wbc
from wbc.view import Meshcat
viewer = Meshcat(wbc.load("simple_humanoid"), port=0, announce=False)
print(viewer.pid, flush=True)
os.kill(os.getpid(), signal.SIGKILL)
"""
    result = python(code)
    assert result.returncode == -signal.SIGKILL
    wait_until(lambda: gone(int(result.stdout)))


def test_a_script_that_never_closes_the_viewer_leaves_no_process():
    code = """
import wbc
from wbc.view import Meshcat
viewer = Meshcat(wbc.load("simple_humanoid"), port=0, announce=False)
print(viewer.pid)
"""
    result = python(code)
    assert result.stderr == ""
    wait_until(lambda: gone(int(result.stdout)))


def test_shared_memory_leaves_no_file(viewer):
    maps = Path(f"/proc/{viewer.pid}/maps")
    if not maps.exists():
        pytest.skip("no /proc here")

    def shared():
        return [line for line in maps.read_text().splitlines() if " rw-s " in line]

    viewer.show(Snapshot(0.0, wbc.load("simple_humanoid").q_nominal))
    wait_until(shared)
    assert all(line.endswith("(deleted)") for line in shared())


def test_a_viewer_of_another_robot_than_the_loops_is_refused(viewer):
    g1 = wbc.load("g1")
    with pytest.raises(ViewerError, match="make the viewer with the plant's robot"):
        viewer.attach(TickStream(g1))


def test_a_configuration_of_another_robot_is_refused(viewer):
    with pytest.raises(StateError, match=r"snapshot\.q"):
        viewer.show(Snapshot(0.0, np.zeros(7)))


def test_a_recording_keeps_its_own_rate_and_copies(robot):
    recording = Recording(robot, rate=25.0)
    q = robot.q_nominal.copy()
    for k in range(1001):
        q[0] = 0.002 * k
        recording.show(Snapshot(0.002 * k, q))
    assert len(recording) == 51
    assert [s.q[0] for s in recording.frames] == pytest.approx(0.04 * np.arange(51))


def test_a_recording_keeps_the_runs_of_a_session_with_its_falls_and_resets(robot):
    recording = Recording(robot, rate=10.0)
    for k in range(10):
        recording.show(Snapshot(0.1 * k, robot.q_nominal))
    recording.on_event(RunEvent(0.9, FALL, reason="the base is low"))
    recording.on_event(RunEvent(0.0, COMMAND, name="reset", outcome="accepted"))
    recording.on_event(RunEvent(0.0, RESET))
    for k in range(5):
        recording.show(Snapshot(0.1 * k, robot.q_nominal))
    assert len(recording) == 15
    assert recording.times == pytest.approx(0.1 * np.arange(15))
    assert [(one.kind, one.text) for one in recording.markers] == [
        ("fall", "the base is low"),
        ("reset", ""),
    ]
    assert [one.time for one in recording.markers] == pytest.approx([0.9, 1.0])


def test_a_long_recording_is_kept_whole_at_a_lower_rate(robot, monkeypatch):
    monkeypatch.setattr("wbc.view.recording._MOST_FRAMES", 20)
    recording = Recording(robot, rate=10.0)
    for k in range(50):
        recording.show(Snapshot(0.1 * k, robot.q_nominal))
    assert len(recording) < 20
    assert recording.times[0] == 0.0
    assert recording.times[-1] > 4.5
    assert recording.rate < 10.0


def test_a_recording_that_fails_leaves_the_former_file(robot, tmp_path, monkeypatch):
    path = tmp_path / "run.html"
    path.write_text("former")
    recording = Recording(robot)
    recording.show(Snapshot(0.0, robot.q_nominal))

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", fail)
    with pytest.raises(ViewerError, match="No space left"):
        recording.save(path)
    assert path.read_text() == "former"
    assert list(tmp_path.iterdir()) == [path]


def test_an_empty_recording_is_refused(robot, tmp_path):
    with pytest.raises(ViewerError, match="nothing was recorded"):
        Recording(robot).save(tmp_path / "none.html")


def test_a_recording_that_cannot_be_written_is_an_error_with_its_path(robot, tmp_path):
    recording = Recording(robot)
    recording.show(Snapshot(0.0, robot.q_nominal))
    (tmp_path / "file").touch()
    with pytest.raises(ViewerError, match="cannot write the recording to"):
        recording.save(tmp_path / "file" / "run.html")


def test_leaving_a_recording_writes_its_file(robot, tmp_path):
    path = tmp_path / "run.html"
    with Recording(robot, path) as recording:
        for k in range(5):
            recording.show(Snapshot(0.1 * k, robot.q_nominal, text="</script>"))
    html = path.read_text("utf-8")
    recording = json.loads(html.split('id="recording">')[1].split("</script>")[0])
    assert [caption["time"] for caption in recording["captions"]] == recording["times"]
    assert recording["times"] == pytest.approx([0.0, 0.1, 0.2, 0.3, 0.4])
    assert recording["captions"][0]["text"] == "</script>"
    assert "http://" not in html.split('id="recording">')[0]
