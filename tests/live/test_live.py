"""The live page without a browser: what may be asked, who may ask, and what the loop does."""

import json
import os
import queue
import re
import signal
import threading
import time
import urllib.error
import urllib.request
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

import wbc
from wbc.driving import drive
from wbc.errors import MotionError
from wbc.live import Live, LiveError
from wbc.live.errors import BadRequest
from wbc.live.gauges import SIZE, Gauges, Mode
from wbc.live.helm import Helm
from wbc.live.panel import LONGEST, Kind
from wbc.motions import Motion, MotionPlayer, Reach, Squat, pack
from wbc.motions.engine.motion import parameter
from wbc.motions.registry import MOTIONS


def motion(name, **parameters):
    value = {"name": name, "parameters": parameters}
    return json.dumps({"control": "motion", "value": value})


BAD = (
    "",
    "velocity",
    "[1, 2]",
    "null",
    '{"value": 1}',
    '{"control": 3, "value": 1}',
    '{"control": "velocity.up", "value": 0.1}',
    '{"control": "velocity.forward"}',
    '{"control": "velocity.forward", "value": "0.1"}',
    '{"control": "velocity.forward", "value": true}',
    '{"control": "velocity.forward", "value": NaN}',
    '{"control": "velocity.forward", "value": -Infinity}',
    '{"control": "velocity.forward", "value": 100}',
    '{"control": "velocity.forward", "value": 1' + "0" * 400 + "}",
    '{"control": "velocity.forward", "value": [0.1]}',
    '{"control": "gait.swing_height", "value": -0.01}',
    '{"control": "com.weight", "value": 0}',
    '{"control": "push", "value": 10}',
    '{"control": "push", "value": [1]}',
    '{"control": "push", "value": [1e9, 0]}',
    '{"control": "push", "value": [NaN, 0]}',
    '{"control": "motion", "value": "skwat"}',
    '{"control": "motion", "value": 0}',
    '{"control": "motion", "value": {"name": "squat"}}',
    motion("skwat"),
    motion(7),
    motion("squat", depht=5.0),
    motion("squat", depth="deep"),
    motion("squat", depth=float("nan")),
    motion("squat", depth=float("inf")),
    motion("squat", depth=True),
    motion("squat", frequency=1e-300),
    motion("squat", times=1.5),
    motion("squat", times=10**9),
    motion("sway", shape="square"),
    motion("sway", shape=["circle"]),
    motion("reach", left=[0.3, 0.2]),
    motion("reach", left=[0.3, None, 1.0]),
    motion("reach", left="here"),
    motion("sine", balanced=1),
    motion("keyframes", file=3),
    motion("keyframes", file="a\0b"),
    '{"control": "motion", "value": {"name": "squat", "parameters": [1]}}',
    '{"control": "motion", "value": {"name": ["squat"], "parameters": {}}}',
    '{"control": "pause", "value": 1}',
    "[" * 900,
    json.dumps({"control": "stand", "value": "x" * LONGEST}),
    b"\x00\x01",
)


@dataclass(frozen=True)
class Shrug(Motion):
    """A motion that somebody adds."""

    name: ClassVar[str] = "shrug"
    summary: ClassVar[str] = "nothing much"
    duration: float = parameter(0.1, "s")

    def play(self, body):
        yield from body.wait(self.duration)


@dataclass(frozen=True)
class Doze(Shrug):
    """A motion that is planned when something lies in a folder."""

    name: ClassVar[str] = "doze"
    folder: str = parameter("", "where")

    def check(self, robot):
        while self.folder and not os.listdir(self.folder):
            time.sleep(0.01)


@dataclass(frozen=True)
class Trip(Shrug):
    """A motion that gives up on the way."""

    name: ClassVar[str] = "trip"

    def play(self, body):
        body.com.move_to(np.array([0.01, 0.0, 0.0]), 0.1)
        yield
        raise wbc.errors.MotionError("trip: over its own feet")


@dataclass(frozen=True)
class Fly(Motion):
    """A motion that no robot can do."""

    name: ClassVar[str] = "fly"
    summary: ClassVar[str] = "away"

    def check(self, robot):
        raise wbc.errors.MotionError("fly: it has no wings")

    def play(self, body):
        yield


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def player(robot):
    return MotionPlayer(robot)


@pytest.fixture
def plant(robot):
    return wbc.sim.Mujoco(robot)


@pytest.fixture
def helm(player, plant, monkeypatch):
    monkeypatch.setattr("wbc.live.helm.Clock.wait", lambda clock: None)
    return Helm(player, plant, MOTIONS, lambda: None)


def ask(helm, control, value=None):
    """As the page's process does it."""
    request = helm.panel.request(json.dumps({"control": control, "value": value}))
    numbers = request.first, request.second
    if request.motion is not None:
        packed = pack(request.motion, helm._performer.robot)
        numbers = helm.shelf.write(packed), len(packed)
    helm.requests.begin()[:] = (request.kind, *numbers)
    helm.requests.publish()


class Notes:
    """Keeps what happens in a run, tick by tick."""

    def __init__(self, player, helm):
        self.player, self.helm = player, helm
        self.time, self.tau, self.dcm, self.playing, self.steps = [], [], [], [], []
        self._joints = []

    @property
    def joints(self):
        return np.array(self._joints)

    def begin(self, controller, plant):
        self.helm.begin()

    def record(self, tick, controller):
        self.time.append(tick.time)
        self.tau.append(tick.command.tau.copy())
        self.dcm.append(self.player.balance.dcm[:2].copy())
        self.playing.append(self.helm.playing)
        self.steps.append(self.player.steps)
        self._joints.append(tick.estimate.state.q[7:].copy())

    def end(self, report):
        pass


def run(helm, player, plant, duration, script):
    """Run, asking (time, control, value) on the way."""
    notes, script = Notes(player, helm), list(script)

    def before_tick(now):
        while script and now >= script[0][0] - 1e-9:
            ask(helm, *script.pop(0)[1:])
        helm(now)

    plant.reset()
    report = wbc.run(player, plant, duration, log=notes, before_tick=before_tick)
    return notes, report


# What may be asked.


@pytest.mark.parametrize("message", BAD, ids=lambda m: repr(m[:40]))
def test_a_message_that_makes_no_sense_is_refused_with_a_reason(helm, message):
    with pytest.raises(BadRequest, match=r"\w{3}"):
        helm.panel.request(message)


def test_a_message_within_the_bounds_is_understood(helm):
    panel = helm.panel
    for i, knob in enumerate(panel.knobs):
        for value in (knob.low, knob.high, knob.value):
            request = panel.request(json.dumps({"control": knob.name, "value": value}))
            assert (request.kind, request.first, request.second) == (Kind.KNOB, i, value)
    push = panel.request(json.dumps({"control": "push", "value": [0, -panel.max_impulse]}))
    assert (push.kind, push.first, push.second) == (Kind.PUSH, 0.0, -panel.max_impulse)
    assert panel.request('{"control": "reset"}').kind is Kind.RESET
    assert panel.request('{"control": "motion", "value": "squat"}').motion == Squat()
    chosen = panel.request(motion("squat", depth=5, times=2)).motion
    assert chosen == Squat(depth=5.0, times=2)
    chosen = panel.request(motion("reach", left=[0.3, 0.2, 1.0], right=None)).motion
    assert chosen == Reach(left=(0.3, 0.2, 1.0))


def test_every_motion_can_be_asked_for_with_all_that_it_offers(helm):
    for told, kind in zip(helm.panel.describe()["motions"], MOTIONS, strict=True):
        values = {p["name"]: p["default"] for p in json.loads(json.dumps(told["parameters"]))}
        assert list(values) == [p.name for p in kind.parameters()]
        assert helm.panel.request(motion(kind.name, **values)).motion == kind()


def test_there_is_a_knob_for_each_task_and_a_button_for_each_motion(helm, player):
    names = {knob.name for knob in helm.panel.knobs}
    for task in player.walker.tasks:
        assert f"{task.name}.weight" in names
    assert {"velocity.forward", "velocity.left", "velocity.turn", "speed"} <= names
    assert {"gait.single_support", "gait.swing_height", "gait.step_width"} <= names
    assert len(names) == len(helm.panel.knobs)
    buttons = [motion["name"] for motion in helm.panel.describe()["motions"]]
    assert buttons == [motion.name for motion in MOTIONS]


# What the loop does.


def test_a_velocity_changes_the_command_of_the_very_tick_after_it(helm, player, plant):
    still, _ = run(helm, player, plant, 0.2, ())
    moved, _ = run(helm, player, plant, 0.2, [(0.1, "velocity.forward", 0.1)])
    differs = [(a != b).any() for a, b in zip(still.tau, moved.tau, strict=True)]
    assert differs.index(True) == 50


def test_a_push_moves_the_dcm_to_the_robots_left_and_is_counted_when_survived(helm, player, plant):
    impulse = 0.1 * player.robot.mass
    still, _ = run(helm, player, plant, 0.4, ())
    pushed, report = run(helm, player, plant, 3.4, [(0.2, "push", [0.0, impulse])])
    k = 170  # 0.14 s after the push set in
    moved = pushed.dcm[k] - still.dcm[k]
    omega = player.walker.gait.omega
    assert moved[1] == pytest.approx(0.1 / omega, rel=0.5)  # Δξ = J / (m ω)
    assert abs(moved[0]) < 0.3 * moved[1]
    assert report.survived
    assert (helm.pushes.survived, helm.pushes.decided) == (1, 1)


def test_a_push_that_fells_it_is_not_survived(helm, player, plant):
    script = [(0.1, "push", [0.0, helm.panel.max_impulse]), (0.2, "push", [0.0, 5.0])]
    _, report = run(helm, player, plant, 3.0, script)
    helm.pushes.fell()
    assert not report.survived
    assert (helm.pushes.survived, helm.pushes.decided) == (0, 2)


def test_one_thing_at_a_time_walking_a_motion_and_walking_again(helm, player, plant):
    sway = [motion.name for motion in MOTIONS].index("sway")
    script = [
        (0.0, "velocity.forward", 0.1),
        (0.8, "motion", "sway"),
        (2.8, "velocity.forward", 0.15),
    ]
    notes, report = run(helm, player, plant, 5.4, script)
    assert report.survived
    playing = np.array(notes.playing)
    begin, end = np.flatnonzero(playing == sway)[[0, -1]]
    assert 1.2 < notes.time[begin] < 2.7  # first it comes to a stand
    assert notes.time[end] == pytest.approx(2.8, abs=0.01)  # it is left off at once
    assert player.velocity == (0.15, 0.0, 0.0)
    assert notes.steps[-1] > notes.steps[end]


def test_arms_wave_while_it_walks_and_the_slider_goes_on_counting(helm, player, plant):
    wave = [motion.name for motion in MOTIONS].index("wave")
    script = [
        (0.0, "velocity.forward", 0.1),
        (1.0, "motion", {"name": "wave", "parameters": {"seconds": 0.5}}),
        (2.5, "velocity.forward", 0.15),
    ]
    notes, report = run(helm, player, plant, 5.5, script)
    assert report.survived
    playing = np.array(notes.playing) == wave
    begin, end = np.flatnonzero(playing)[[0, -1]]
    assert begin == 500
    assert notes.time[end] > 2.6
    assert not playing[-1]
    assert player.velocity == (0.15, 0.0, 0.0)
    assert notes.steps[begin] < notes.steps[end] < notes.steps[-1]
    arms = player.context.upper_body.both_arms()
    home = player.context.posture.home
    raised = max(abs(notes.joints - home)[begin:end][:, list(arm.joints)].max() for arm in arms)
    assert raised > 0.5


def test_the_push_that_a_motion_asks_for_is_granted_and_counted(helm, player, plant):
    pushed = []
    plant_push = plant.push
    helm._push_torso = lambda impulse: (pushed.append(impulse), plant_push(impulse))
    parameters = {"leg": "left", "hold": 0.4, "impulse": 0.02}
    script = [(0.0, "motion", {"name": "one-leg", "parameters": parameters})]
    _, report = run(helm, player, plant, 8.0, script)
    assert report.survived
    assert len(pushed) == 1
    assert np.linalg.norm(pushed[0]) == pytest.approx(0.02 * player.robot.mass)
    assert (helm.pushes.survived, helm.pushes.decided) == (1, 1)


def test_nothing_is_checked_or_planned_in_the_loop(helm, player, plant, monkeypatch):
    script = [(0.0, "motion", "squat"), (0.1, "motion", "reach"), (0.3, "motion", "wave")]
    requests = [
        (at, control, helm.panel.request(motion(name)).motion) for at, control, name in script
    ]
    packed = [pack(m, player.robot) for _, _, m in requests]
    for kind in MOTIONS:
        monkeypatch.setattr(kind, "check", None)
    monkeypatch.setattr("wbc.ik.posture_ik.PostureIK.find", None)
    helm.begin()
    estimate = wbc.Estimate(player.robot.standing())
    for data in packed:
        helm.requests.begin()[:] = (Kind.MOTION, helm.shelf.write(data), len(data))
        helm.requests.publish()
        for _ in range(1500):
            helm(0.0)
            player.step(estimate)
            if helm.playing >= 0:
                break
        assert helm.playing >= 0


def test_stand_leaves_everything_off(helm, player, plant):
    script = [(0.0, "motion", "sway"), (0.5, "motion", "squat"), (0.6, "stand")]
    notes, _ = run(helm, player, plant, 2.5, script)
    assert notes.playing[-1] == -1
    assert set(notes.playing[400:]) <= {-1, -2}


def test_a_motion_that_turns_out_impossible_leaves_it_standing(robot, player, plant, monkeypatch):
    monkeypatch.setattr("wbc.live.helm.Clock.wait", lambda clock: None)

    helm = Helm(player, plant, (Trip,), lambda: None)
    notes, report = run(helm, player, plant, 3.0, [(0.0, "motion", "trip")])
    assert report.survived
    assert notes.playing[-1] == -1
    assert player.context.at_home
    assert "over its own feet" in player.context.notes[0]


def test_pause_stops_time_and_requests_are_still_taken(helm, player, plant):
    seen = []

    def idle():
        seen.append((plant.time, player.walker.com.weight[0]))
        if len(seen) == 3:
            ask(helm, "com.weight", 1000.0)
        if len(seen) == 6:
            ask(helm, "pause", False)

    helm._idle = idle
    notes, _ = run(helm, player, plant, 0.1, [(0.04, "pause", True)])
    assert len(seen) >= 6
    assert {time for time, _ in seen} == {0.04}
    assert seen[-1][1] == 1000.0
    assert len(notes.time) == 50


def test_slow_motion_makes_ticks_rarer(player, plant):
    helm = Helm(player, plant, MOTIONS, lambda: None)
    ask(helm, "speed", 0.05)
    start = time.perf_counter()
    run(helm, player, plant, 0.02, ())
    assert time.perf_counter() - start > 9 * 0.002 / 0.05 - 0.01


def test_a_reset_ends_the_run_once(helm, player, plant):
    script = [(0.05, "reset"), (0.05, "reset")]
    _, report = run(helm, player, plant, 0.2, script)
    assert helm.reset_wanted
    assert report.duration_s == pytest.approx(0.048, abs=1e-6)
    _, report = run(helm, player, plant, 0.1, [(0.0, "reset")])  # it is as good as reset
    assert report.survived


def test_a_gain_keeps_the_ratios_of_its_rows(helm, player, plant):
    posture = player.walker.posture
    before = posture.weight.copy()
    top = before.max()
    _, report = run(helm, player, plant, 0.1, [(0.02, "posture.weight", 3.0 * top)])
    assert report.qp_failures == 0
    np.testing.assert_allclose(posture.weight, 3.0 * before)


def test_gait_parameters_may_be_turned_to_their_ends_while_it_walks(helm, player, plant):
    knobs = [knob for knob in helm.panel.knobs if knob.group == "gait"]
    script = [(0.0, "velocity.forward", 0.15)]
    at = 1.5
    for knob in knobs:
        for value in (knob.high, knob.low, knob.value):
            script.append((at, knob.name, value))
            at += 0.4
    _, report = run(helm, player, plant, at + 0.5, script)
    assert report.survived, report.fell_why
    assert player.walker.gait == wbc.gait.GaitParameters.for_robot(player.robot)


# The page's process.


class Client:
    """A web socket on a thread of its own, for tests that wait in words of one line."""

    def __init__(self, url, path="controls", origin=None):
        self.heard = queue.Queue()
        self._url = url.replace("http", "ws").replace("static/", path)
        self._headers = {} if origin is None else {"Origin": origin}
        self._ready = threading.Event()
        self.refused = None
        threading.Thread(target=self._run, daemon=True).start()
        assert self._ready.wait(20.0)

    def _run(self):
        import asyncio

        asyncio.run(self._listen())

    async def _listen(self):
        import asyncio

        from tornado.httpclient import HTTPError, HTTPRequest
        from tornado.websocket import websocket_connect

        self._loop = asyncio.get_running_loop()
        request = HTTPRequest(self._url, headers=self._headers)
        try:
            self._socket = await websocket_connect(request, max_message_size=1 << 28)
        except HTTPError as error:
            self.refused = error.code
            self._ready.set()
            return
        self._ready.set()
        while (message := await self._socket.read_message()) is not None:
            if isinstance(message, str):
                self.heard.put(json.loads(message))
        self.heard.put(None)

    def say(self, message):
        binary = isinstance(message, bytes)
        self._loop.call_soon_threadsafe(self._socket.write_message, message, binary)

    def ask(self, control, value=None):
        self.say(json.dumps({"control": control, "value": value}))

    def hear(self, key):
        """The next news of that kind."""
        while True:
            news = self.heard.get(timeout=20.0)
            if news is None or key in news:
                return news

    def close(self):
        self._loop.call_soon_threadsafe(self._socket.close)


@pytest.fixture
def live(player, plant):
    motions = (Squat, Shrug, Doze, Fly)
    with Live(player, plant, port=0, motions=motions, announce=False) as live:
        yield live


def taken(live, count):
    """Take requests as the loop does, until there were so many."""
    end = time.monotonic() + 20.0
    while live.helm.taken < count and time.monotonic() < end:
        live.helm.lie()
    assert live.helm.taken == count


def test_a_bad_message_is_answered_and_ignored_and_the_next_one_counts(live):
    page = Client(live.url)
    panel = page.hear("panel")["panel"]
    assert [motion["name"] for motion in panel["motions"]][-2:] == ["doze", "fly"]
    for message in BAD:
        page.say(message)
        assert page.hear("error")["error"]
    page.ask("com.weight", 2000.0)
    taken(live, 1)
    assert live._performer.walker.com.weight[0] == 2000.0


def test_a_message_of_a_megabyte_costs_its_sender_the_connection_and_nobody_else(live):
    rude, page = Client(live.url), Client(live.url)
    rude.say("x" * (1 << 20))
    while rude.heard.get(timeout=20.0) is not None:
        pass
    page.ask("pause", True)
    taken(live, 1)
    assert live.helm.paused


def test_pages_agree_and_one_that_leaves_or_comes_back_harms_nothing(live):
    one, two = Client(live.url), Client(live.url)
    two.hear("values")
    one.ask("velocity.forward", 0.1)
    assert two.hear("values")["values"] == {"velocity.forward": 0.1}
    one.close()
    taken(live, 1)
    two.ask("velocity.turn", 0.2)
    taken(live, 2)
    again = Client(live.url).hear("values")["values"]
    assert (again["velocity.forward"], again["velocity.turn"]) == (0.1, 0.2)


def test_a_motion_that_the_robot_cannot_do_is_told_and_never_reaches_the_loop(live):
    page = Client(live.url)
    page.ask("motion", "fly")
    assert "no wings" in page.hear("error")["error"]
    page.ask("motion", "shrug")
    taken(live, 1)
    later = Client(live.url)
    while "fly" not in later.hear("unable")["unable"]:
        pass  # the checks of all of them take their time


def test_a_motion_is_planned_with_its_parameters_before_the_loop_hears_of_it(live):
    page = Client(live.url)
    page.say(motion("squat", depth=90.0))
    assert "cannot go down by 90 %" in page.hear("error")["error"]
    page.say(motion("shrug", duration=0.2))
    taken(live, 1)
    assert live.helm.manager.waiting == Shrug(0.2)


def test_a_motion_that_is_still_being_planned_is_forgotten_for_something_else(live, tmp_path):
    page = Client(live.url)
    page.say(motion("doze", folder=str(tmp_path)))
    assert page.hear("planning")["planning"] == "doze"
    page.ask("stand")
    assert page.hear("planning")["planning"] is None
    taken(live, 1)
    page.say(motion("shrug", duration=0.3))  # is planned after the other one
    assert page.hear("planning")["planning"] == "shrug"
    (tmp_path / "alarm").touch()
    taken(live, 2)
    assert live.helm.manager.waiting == Shrug(0.3)


def test_a_motion_whose_planning_breaks_is_told_and_the_page_goes_on(live):
    page = Client(live.url)
    page.say(motion("doze", folder="nowhere"))
    assert "FileNotFoundError" in page.hear("error")["error"]
    page.say(motion("shrug", duration=0.3))
    taken(live, 1)


def test_a_loop_that_does_not_listen_is_told_of(live):
    page = Client(live.url)
    for k in range(60):
        page.ask("velocity.forward", 0.001 * k)
    assert "too many" in page.hear("error")["error"]


@pytest.mark.parametrize("path", ["controls", "socket"])
def test_pages_of_other_origins_are_refused(live, path):
    assert Client(live.url, path, origin="http://elsewhere.example").refused == 403
    assert Client(live.url, path, origin="null").refused == 403
    here = live.url.replace("/static/", "")
    assert Client(live.url, path, origin=here).refused is None


@pytest.mark.parametrize(
    ("method", "headers", "code"),
    [
        ("GET", {"Host": "elsewhere.example"}, 404),
        ("POST", {}, 405),
        ("PUT", {"Origin": "http://elsewhere.example"}, 405),
    ],
)
def test_requests_by_another_name_or_that_would_change_something_are_refused(
    live, method, headers, code
):
    data = b"{}" if method != "GET" else None
    request = urllib.request.Request(live.url, data=data, headers=headers, method=method)
    with pytest.raises(urllib.error.HTTPError) as refusal:
        urllib.request.urlopen(request, timeout=20.0)
    assert refusal.value.code == code


@pytest.mark.parametrize(
    ("listening", "name", "known"),
    [
        ("127.0.0.1", "localhost", True),
        ("127.0.0.1", "192.168.1.5", False),
        ("192.168.1.5", "192.168.1.5", True),
        ("192.168.1.5", "192x168.1.5", False),
        ("0.0.0.0", "10.0.0.7", True),
        ("0.0.0.0", "10.0.0.7.example", False),
        ("0.0.0.0", "rebound.example", False),
        ("::", "[fe80::1]", True),
    ],
)
def test_a_page_open_to_the_network_is_asked_for_by_address_not_by_any_name(listening, name, known):
    from wbc.live.server import _names

    assert bool(re.fullmatch(_names(listening), name)) is known


def test_a_motion_that_another_process_could_not_find_is_refused_with_the_cure(player, plant):
    class Hidden(Shrug):
        name = "hidden"

    with pytest.raises(MotionError, match=r"'hidden' is defined where .* module of its own"):
        Live(player, plant, port=0, motions=(Hidden,), announce=False)


def test_the_page_needs_nothing_from_elsewhere(live):
    from wbc.live.server import _OWN

    for name in ("", *_OWN, "stage.js", "live.js"):
        with urllib.request.urlopen(live.url + name, timeout=20.0) as answer:
            text = answer.read().decode()
        assert len(text) > 500
        assert "http://" not in text.replace("http://www.w3.org/2000/svg", "")
        assert "https://" not in text


def test_a_port_that_is_taken_is_told(live, player, plant):
    port = int(live.url.split(":")[2].split("/")[0])
    with pytest.raises(LiveError, match=f"port {port} is in use"):
        Live(player, plant, port=port, announce=False)


def test_the_run_goes_on_when_the_pages_process_dies_and_says_so_once(
    live, player, plant, monkeypatch, caplog
):
    monkeypatch.setattr("wbc.live.helm.Clock.wait", lambda clock: None)
    monkeypatch.setattr("wbc.process.child._CHECK_PERIOD", 0.0)
    monkeypatch.setattr("wbc.live.live._GAUGES", np.inf)  # it looks whenever it tells figures

    def die(now):
        if abs(now - 0.1) < 1e-9:
            os.kill(live.pid, signal.SIGKILL)
            while live.alive:
                time.sleep(0.01)
        live.helm(now)

    report = wbc.run(player, plant, 0.2, log=live, before_tick=die)
    assert report.survived
    assert report.duration_s == pytest.approx(0.198)
    assert [record.message.count("the live page") for record in caplog.records] == [1]


def test_pages_that_come_and_go_leave_nothing_behind(live):
    files = Path(f"/proc/{live.pid}/fd")
    if not files.is_dir():
        pytest.skip("no /proc here")
    staying = Client(live.url)
    staying.hear("unable")
    before = len(list(files.iterdir()))
    for k in range(50):
        Client(live.url, ("controls", "socket")[k % 2]).close()
    end = time.monotonic() + 20.0
    while len(list(files.iterdir())) > before:
        assert time.monotonic() < end
        time.sleep(0.05)
    staying.ask("pause", True)
    taken(live, 1)
    live.close()
    assert not Path(f"/proc/{live.pid}").exists()


@contextmanager
def driven(live, player, plant, duration):
    """The run on a thread; its notes on the way."""
    told = []
    stop = threading.Event()
    thread = threading.Thread(
        target=drive,
        args=(live, player, plant, duration),
        kwargs={"told": told.append, "stop": stop.is_set},
        daemon=True,
    )
    thread.start()
    yield told
    stop.set()
    thread.join(60.0)
    assert not thread.is_alive()


def test_it_falls_lies_and_is_set_on_its_feet_and_gauges_tell(live, player, plant, monkeypatch):
    monkeypatch.setattr("wbc.live.helm.Clock.wait", lambda clock: None)
    page = Client(live.url)

    def until(condition):
        while not condition(gauges := page.hear("gauges")["gauges"]):
            pass
        return gauges

    with driven(live, player, plant, 1000.0) as told:
        first = until(lambda g: g["mode"] == "running" and g["time"] > 0.1)
        assert 0.0 < first["tick_time"] < 1.0
        page.ask("velocity.forward", 0.1)
        until(lambda g: g["velocity"] == [0.1, 0.0, 0.0])
        page.ask("push", [0.0, live.helm.panel.max_impulse])
        until(lambda g: g["mode"] == "fallen" and g["pushes"] == 1 and g["survived"] == 0)
        page.ask("reset")
        until(lambda g: g["mode"] == "running")
        page.ask("pause", True)
        until(lambda g: g["mode"] == "paused")
        page.ask("reset")
        until(lambda g: g["mode"] == "running")
        page.ask("pause", True)  # and so it ends: what is paused can be stopped
        until(lambda g: g["mode"] == "paused")
    assert [line.split(":")[0] for line in told][1:] == ["fell", "reset", "reset"]


def test_gauges_are_what_was_recorded():
    record = np.arange(SIZE, dtype=float)
    record[1] = Mode.PAUSED
    gauges = Gauges.of(record)
    assert gauges.mode is Mode.PAUSED
    assert (gauges.time, gauges.turn, gauges.run) == (0.0, 6.0, SIZE - 1)
