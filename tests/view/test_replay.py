"""A run that is over can be moved through, made into a video, and gives what was shown."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from cases import slow
from needs import need_browser

import wbc
from wbc.atomic_file import replacing
from wbc.telemetry import Telemetry
from wbc.view import Recording, Replay, Snapshot, TimeSeries, Video, VideoFormat, ViewerError
from wbc.view.browser import new_page
from wbc.view.timeline import record, thinned, up_to

ROOT = Path(wbc.__file__).parent.parent
TIMEOUT = 120_000  # ms: software rendering on a busy machine


@dataclass
class LinearTimeline:
    """A timeline of a robot that moves forward at 1 m/s."""

    robot: wbc.Robot
    start: float = 2.0
    end: float = 12.0

    def at(self, time):
        time = min(max(time, self.start), self.end)
        v = np.zeros(self.robot.nv)
        v[0] = time - self.start
        q = pin.integrate(self.robot.model, self.robot.q_nominal, v)
        zmp = np.array([time, 0.0, 0.0])
        return Snapshot(time, q, telemetry=Telemetry(zmp=zmp), text=f"t = {time:.3f}")


@pytest.fixture(scope="module")
def timeline():
    return LinearTimeline(wbc.load("simple_humanoid"))


def test_seeking_replays_the_preceding_snapshots(timeline):
    times = [s.time for s in up_to(timeline, 7.0, None, 2.0)]
    assert times[0] == pytest.approx(5.0, abs=0.07)
    assert times[-1] == 7.0
    assert (np.diff(times) > 0).all()
    assert max(np.diff(times)) < 0.07
    # Going on needs only what is new; going back begins anew.
    assert [s.time for s in up_to(timeline, 7.02, 7.0, 2.0)] == [7.02]
    assert next(iter(up_to(timeline, 6.0, 7.0, 2.0))).time < 6.0
    assert [s.time for s in up_to(timeline, 99.0, 11.99, 2.0)] == [12.0]


@pytest.mark.parametrize("time", [float("nan"), float("inf")])
def test_a_time_that_is_not_finite_is_refused(timeline, time):
    with pytest.raises(ViewerError, match="must be finite"):
        Replay(timeline.robot, timeline).new_scene().show(time)


def test_seeking_backwards_shows_the_same_frame_as_before(timeline):
    replay_scene = Replay(timeline.robot, timeline).new_scene()
    replay_scene.show(4.0)
    before = replay_scene.scene.poses.copy()
    replay_scene.show(9.0)
    assert np.abs(replay_scene.scene.poses - before).max() > 1.0
    replay_scene.show(4.0)
    visible = before[:, 7] > 0
    assert ((replay_scene.scene.poses[:, 7] > 0) == visible).all()
    np.testing.assert_allclose(replay_scene.scene.poses[visible], before[visible], atol=1e-9)


@dataclass
class ResetTimeline(LinearTimeline):
    """The robot was put back to the start at 7 s."""

    def at(self, time):
        snapshot = super().at(time)
        if snapshot.time < 7.0:
            return snapshot
        return replace(super().at(snapshot.time - 5.0), time=snapshot.time, run=2)


def test_the_trail_breaks_at_a_reset(timeline):
    scene = Replay(timeline.robot, ResetTimeline(timeline.robot)).new_scene()
    trail = [i for i, path in enumerate(scene.scene.paths) if "/trail/" in path]

    def shown():
        poses = scene.scene.poses[trail]
        return poses[poses[:, 7:].min(axis=1) > 0.0]

    scene.show(6.9)
    before = shown()
    assert before[:, 0].max() > 4.0
    scene.show(7.5)  # the history that is rebuilt includes the time before the reset
    after = shown()
    assert 5 < len(after) < len(before)
    assert after[:, 0].max() < 1.0, "no rod leads from where the robot was before"
    assert after[:, 9].max() < 0.2


def test_thinned_time_series_keep_their_peaks():
    values = np.zeros(10_000)
    values[[123, 9_999]] = (5.0, 3.0)
    values[500:700] = np.nan
    (series,) = thinned([TimeSeries("error, mm", np.arange(10_000.0), values)], 100)
    assert len(series.values) <= 100
    assert series.values.max() == 5.0
    assert series.values[-1] == 3.0


def test_a_video_is_recorded_at_the_recordings_rate(timeline):
    recording = Recording(timeline.robot, rate=25.0)
    record(timeline, recording)
    times = [s.time for s in recording.frames]
    np.testing.assert_allclose(times, np.arange(2.0, 12.001, 0.04), atol=1e-9)


@pytest.fixture
def served(timeline, tmp_path):
    """A replay in a process of its own; its address."""
    code = """
import sys
sys.path[:0] = sys.argv[1:]
import wbc
from test_replay import LinearTimeline
from wbc.view import Replay, TimeSeries
timeline = LinearTimeline(wbc.load("simple_humanoid"))
import numpy as np
series = TimeSeries("lean, mm", np.array([2.0, 7.0, 12.0]), np.array([0.0, 3.0, 1.0]))
Replay(timeline.robot, timeline, port=0, series=[series]).serve(lambda url: print(url, flush=True))
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code, str(Path(__file__).parent), str(ROOT / "tests" / "tools")],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    yield process, process.stdout.readline().strip()
    process.kill()
    process.wait()
    process.stdout.close()


def test_ctrl_c_ends_a_replay_without_output(served):
    process, url = served
    assert url.startswith("http://127.0.0.1:")
    process.send_signal(signal.SIGINT)
    assert process.wait(10.0) == 0


def test_requests_of_other_sites_are_refused(served):
    _, url = served
    request = urllib.request.Request(url, headers={"Host": "example.org"})
    with pytest.raises(urllib.error.HTTPError):
        urllib.request.urlopen(request)


def test_invalid_messages_of_a_page_are_answered_and_ignored(served):
    from tornado.httpclient import HTTPRequest
    from tornado.websocket import websocket_connect

    _, url = served

    async def talk():
        address = url.replace("http", "ws").replace("static/", "socket")
        foreign = HTTPRequest(address, headers={"Origin": "http://example.org"})
        with pytest.raises(Exception, match="403"):
            await websocket_connect(foreign)
        socket = await websocket_connect(address, max_message_size=2**28)
        while True:
            message = await socket.read_message()
            if isinstance(message, str) and "paths" in message:
                break
        answers = []
        for nonsense in ("{", "[]", '{"time": "soon"}', '{"time": null}', '{"time": NaN}', "7"):
            await socket.write_message(nonsense)
            answers.append(json.loads(await socket.read_message()))
        frames = []
        for at in (3.5, 3.5, 3.6):
            await socket.write_message(json.dumps({"time": at}))
            frames.append(json.loads(await socket.read_message()))
        return json.loads(message), answers, frames

    introduction, answers, (first, same, later) = asyncio.run(talk())
    assert (introduction["start"], introduction["end"]) == (2.0, 12.0)
    assert introduction["series"][0]["values"] == [0.0, 3.0, 1.0]
    assert all("error" in answer for answer in answers)
    assert first["caption"]["time"] == 3.5
    assert len(first["nodes"]) == len(introduction["paths"])
    assert same["nodes"] == []  # only the changed poses are sent
    assert 0 < len(later["nodes"]) < len(first["nodes"])
    assert len(later["poses"]) == 10 * len(later["nodes"])


@pytest.mark.browser
def test_replay_page_plays_seeks_and_steps(served):
    need_browser()
    _, url = served
    with new_page(400, 300) as page:
        page.set_default_timeout(TIMEOUT)
        errors = []
        page.on("pageerror", lambda error: errors.append(error))
        page.goto(url)
        page.wait_for_function("wbc.ready && wbc.time > 2.0")  # it plays by itself
        page.keyboard.press(" ")
        page.wait_for_function("!wbc.player.playing")
        page.evaluate("element('seek').value = 8; element('seek').oninput()")
        page.wait_for_function("wbc.time === 8 && !waiting")
        camera = "nodesAt(['/Cameras/default'])[0].position.x"
        there = page.evaluate(camera)
        page.keyboard.press("ArrowRight")
        page.wait_for_function("wbc.time === 8.02")
        page.keyboard.press("Shift+ArrowLeft")
        page.wait_for_function("wbc.time === 7.02")
        page.keyboard.press("Home")
        page.wait_for_function("wbc.time === 2 && !waiting")
        assert page.evaluate("element('text').textContent") == "t = 2.000"
        here = page.evaluate(camera)
        assert there - here == pytest.approx(6.0, abs=0.6)
        assert page.evaluate("document.querySelectorAll('.series').length") == 1
        assert errors == []


@pytest.mark.browser
@pytest.mark.parametrize("suffix", [".mp4", slow(".gif")])
def test_a_video_has_the_recordings_frames_with_motion(timeline, tmp_path, monkeypatch, suffix):
    monkeypatch.setattr("wbc.view.video.usable_cores", lambda: 2)
    monkeypatch.setattr("wbc.view.video._FRAMES_PER_BROWSER", 3)
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    need_browser()
    recording = Recording(timeline.robot, rate=5.0)
    for k in range(6):
        recording.show(timeline.at(2.0 + 0.2 * k))
    told = []
    video_format = VideoFormat((320, 240), rate=5.0, camera=(0.0, 10.0, 4.0))
    path = Video(tmp_path / "deep" / f"timeline{suffix}", video_format).render(
        recording, lambda done, frames: told.append((done, frames))
    )
    assert told == [(k, 6) for k in range(1, 7)]
    reader = imageio_ffmpeg.read_frames(str(path), pix_fmt="gray", bits_per_pixel=8)
    facts = next(reader)
    assert facts["size"] == (320, 240)
    assert facts["fps"] == 5.0
    pictures = [np.frombuffer(data, np.uint8).astype(float) for data in reader]
    assert len(pictures) == 6
    assert pictures[0].std() > 10.0  # there is something in the picture
    assert np.abs(pictures[5] - pictures[0]).max() > 50.0


def test_a_video_of_an_odd_size_is_refused(tmp_path):
    with pytest.raises(ViewerError, match="width is 321"):
        VideoFormat((321, 240))


def test_a_video_of_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(ViewerError, match=r"walk\.avi is neither \.mp4 nor \.gif"):
        Video(tmp_path / "walk.avi")


@pytest.mark.parametrize(
    "wrong", [{"rate": 0.0}, {"camera": (0.0, 90.0, 3.0)}, {"camera": (0.0, 0.0, 0.0)}]
)
def test_an_impossible_video_format_is_refused(wrong):
    with pytest.raises(ViewerError, match=r"the rate is|the camera is"):
        VideoFormat(**wrong)


def test_a_missing_encoder_is_an_error_with_its_pip_command(tmp_path, monkeypatch):
    import importlib.util
    import shutil

    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(wbc.errors.MissingExtra, match=r"pip install 'wbc\[video\]'"):
        Video(tmp_path / "timeline.mp4")


def test_a_video_that_fails_leaves_no_file(tmp_path):
    need_browser()
    video = Video(tmp_path / "timeline.mp4")

    def fill(interrupt):
        with replacing(video.path) as file, video._encoding(file) as frames_in:
            frames_in.write(b"no picture")
            if interrupt:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill(interrupt=True)
    assert not video.path.exists()
    with pytest.raises(ViewerError, match="cannot be encoded"):
        fill(interrupt=False)
    assert not video.path.exists()


def test_on_ready_is_called_once_the_replay_is_served(timeline):
    ready = threading.Event()
    replay = Replay(timeline.robot, timeline, port=0)

    async def once():
        task = asyncio.ensure_future(replay._serve(lambda url: ready.set()))
        await asyncio.sleep(0)
        start = time.monotonic()
        while not ready.is_set() and time.monotonic() < start + 5.0:
            await asyncio.sleep(0.01)
        task.cancel()

    asyncio.run(once())
    assert ready.is_set()
