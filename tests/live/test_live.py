"""The live page without a browser: what may be asked, who may ask, and what becomes of it."""

import contextlib
import functools
import json
import math
import os
import queue
import re
import signal
import tempfile
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path
from pwd import struct_passwd

import numpy as np
import pytest
from motiontools import InfeasibleMotion, SlowlyPlannedMotion, WaitingMotion
from processtools import wait_until

import wbc
from wbc.live import Live, LiveError
from wbc.live.controls import MAX_LENGTH, Controls, decode
from wbc.live.uploads import Uploads
from wbc.log import LoggedRun
from wbc.motions import MOTIONS, MotionPlayer, Reach, Squat
from wbc.runtime.loop import StopRun
from wbc.teleop import (
    CommandHandler,
    CommandRefused,
    GainCommand,
    GaitParameterCommand,
    MotionCommand,
    PauseCommand,
    PushCommand,
    ResetCommand,
    StandCommand,
    TimeScaleCommand,
    VelocityCommand,
)


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
    '{"control": "com.weight", "value": -1}',
    '{"control": "com.weight", "value": 1}',
    '{"control": "com.kp", "value": 0}',
    '{"control": "frame_task", "value": {"frame": "left_foot", "kind": "position", "weight": 1}}',
    '{"control": "frame_task", "value": {"frame": "head", "kind": "pose", "weight": 1}}',
    '{"control": "frame_task", "value": {"frame": "head", "kind": "position", "weight": -1}}',
    '{"control": "frame_task", "value": "head"}',
    '{"control": "hand", "value": {"side": "left", "target": [0, 0]}}',
    '{"control": "hand", "value": {"side": "tail", "target": null}}',
    '{"control": "start_session", "value": "talos"}',
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
    motion("keyframes", file="../up.csv"),
    motion("keyframes", file="/etc/passwd"),
    motion("reach", left=[0.3, None, 1.0]),
    motion("reach", left="here"),
    motion("sine", open_loop=1),
    motion("keyframes", file=3),
    motion("keyframes", file="a\0b"),
    '{"control": "motion", "value": {"name": "squat", "parameters": [1]}}',
    '{"control": "motion", "value": {"name": ["squat"], "parameters": {}}}',
    '{"control": "pause", "value": 1}',
    "[" * 900,
    json.dumps({"control": "stand", "value": "x" * MAX_LENGTH}),
    '{"control": "stand", "source": "elsewhere"}',
    b"\x00\x01",
)


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def player(robot):
    return MotionPlayer(robot)


@pytest.fixture
def plant(robot):
    return wbc.sim.Mujoco(robot)


# Requests and the commands that they give.


@pytest.fixture
def capabilities(player, plant):
    with CommandHandler(player, plant) as handler:
        return handler.capabilities


@pytest.fixture
def uploads(tmp_path):
    return Uploads(tmp_path)


@pytest.fixture
def controls(capabilities, uploads):
    return Controls(capabilities, uploads)


def parsed(controls, message):
    return controls.command(decode(message))


@pytest.mark.parametrize("message", BAD, ids=lambda m: repr(m[:40]))
def test_an_invalid_message_is_refused_with_a_reason(controls, capabilities, message):
    with pytest.raises(CommandRefused, match=r"\w{3}"):
        capabilities.check(parsed(controls, message))


@pytest.mark.parametrize(
    ("control", "value", "command"),
    [
        ("velocity.left", 0.1, VelocityCommand(0.0, 0.1, 0.0)),
        ("speed", 0.5, TimeScaleCommand(0.5)),
        ("gait.swing_height", 0.05, GaitParameterCommand("swing_height", 0.05)),
        ("com.weight", 1000.0, GainCommand("com", "weight", 1000.0)),
        ("push", [1, -2.0], PushCommand((1, -2.0, 0.0))),
        ("motion", "squat", MotionCommand(Squat())),
        ("pause", True, PauseCommand(True)),
        ("stand", None, StandCommand()),
        ("reset", None, ResetCommand()),
    ],
)
def test_each_control_gives_its_command(controls, capabilities, control, value, command):
    message = {"control": control, "value": value}
    assert parsed(controls, json.dumps(message)) == command
    assert decode(json.dumps(message)).source == "page"
    assert decode(json.dumps({**message, "source": "keyboard"})).source == "keyboard"
    capabilities.check(command)


def test_a_slider_may_be_set_to_its_bounds(controls, capabilities):
    for parameter in controls.describe()["parameters"]:
        for value in (parameter["low"], parameter["high"], parameter["default"]):
            message = json.dumps({"control": parameter["name"], "value": value})
            command = parsed(controls, message)
            capabilities.check(command)
            controls.apply(command)
            assert controls.values[parameter["name"]] == value
    largest = [0, -controls.max_impulse]
    capabilities.check(parsed(controls, json.dumps({"control": "push", "value": largest})))


def test_velocity_sliders_form_one_command_and_are_zeroed_together(controls):
    for name, value in (("forward", 0.1), ("turn", 0.2)):
        message = json.dumps({"control": f"velocity.{name}", "value": value})
        command = parsed(controls, message)
        assert controls.apply(command) == {f"velocity.{name}": value}
    assert command == VelocityCommand(0.1, 0.0, 0.2)
    assert set(controls.zero_velocity().values()) == {0.0}
    assert parsed(controls, '{"control": "velocity.turn", "value": 0.1}').forward == 0.0


def test_a_motion_request_may_have_parameters(controls):
    chosen = parsed(controls, motion("squat", depth=5, times=2)).motion
    assert chosen == Squat(depth=5.0, times=2)
    chosen = parsed(controls, motion("reach", left=[0.3, 0.2, 1.0], right=None)).motion
    assert chosen == Reach(left=(0.3, 0.2, 1.0))
    for told, kind in zip(controls.describe()["motions"], MOTIONS, strict=True):
        values = {p["name"]: p["default"] for p in json.loads(json.dumps(told["parameters"]))}
        assert list(values) == [p.name for p in kind.parameters()]
        assert parsed(controls, motion(kind.name, **values)).motion == kind()


# The process of the page.


class Client:
    """A web socket on a thread of its own, whose messages a test awaits one by one."""

    def __init__(self, url, path="controls", origin=None):
        self._received = queue.Queue()
        base, _, token = url.partition("?")
        self._url = base.replace("http", "ws").replace("static/", path) + (token and f"?{token}")
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
                self._received.put(json.loads(message))
        self._received.put(None)

    def send(self, message):
        binary = isinstance(message, bytes)
        self._loop.call_soon_threadsafe(self._socket.write_message, message, binary)

    def request(self, control, value=None):
        self.send(json.dumps({"control": control, "value": value}))

    def receive(self, key):
        """Return the next message that has a key; None when the connection is closed."""
        while True:
            message = self._received.get(timeout=20.0)
            if message is None or key in message:
                return message

    def received(self):
        """Return the messages that have come and were not returned yet."""
        return [self._received.get() for _ in range(self._received.qsize())]

    def close(self):
        self._loop.call_soon_threadsafe(self._socket.close)


@contextlib.contextmanager
def page_handler(player, plant):
    motions = (Squat, WaitingMotion, SlowlyPlannedMotion, InfeasibleMotion)
    with CommandHandler(player, plant, motions=motions) as handler:
        yield handler


def page_of(handler):
    return Live(handler, port=0, announce=False, token="")


@pytest.fixture
def handler(player, plant):
    with page_handler(player, plant) as handler:
        yield handler


@pytest.fixture
def live(handler):
    with page_of(handler) as live:
        yield live


# A server takes seconds to start: one for all the tests that leave it as it was.


@pytest.fixture(scope="module")
def lasting_handler(robot):
    with page_handler(MotionPlayer(robot), wbc.sim.Mujoco(robot)) as handler:
        yield handler


@pytest.fixture(scope="module")
def lasting(lasting_handler):
    with page_of(lasting_handler) as live:
        yield live


@pytest.fixture
def take(lasting_handler, lasting):
    """Apply commands as the loop does until there were `count`; return them all."""
    handler, applied = lasting_handler, []

    def observe(sent, _):
        applied.append(sent)

    def take(count):
        end = time.monotonic() + 20.0
        while len(applied) < count and time.monotonic() < end:
            with contextlib.suppress(StopRun):  # a pause ends at once
                handler.before_tick(0.0)
            time.sleep(0.005)
        assert len(applied) == count
        return applied

    handler.begin()
    handler.stop = lambda: True
    handler.add_observer(observe)
    yield take
    handler.remove_observer(observe)


def test_an_invalid_message_is_answered_and_the_next_one_is_applied(lasting, take, lasting_handler):
    page = Client(lasting.url)
    offered = page.receive("controls")["controls"]
    assert [motion["name"] for motion in offered["motions"]][-2:] == [
        "slowly_planned",
        "infeasible_motion",
    ]
    for message in BAD:
        page.send(message)
        assert page.receive("error")["error"]
    page.request("com.weight", 2000.0)
    take(1)
    assert lasting_handler.player.walker.com.weight[0] == 2000.0


def test_a_message_of_a_megabyte_closes_only_its_senders_connection(lasting, take, lasting_handler):
    rude, page = Client(lasting.url), Client(lasting.url)
    rude.send("x" * (1 << 20))
    while rude._received.get(timeout=20.0) is not None:
        pass
    page.request("pause", True)
    take(1)
    assert lasting_handler.paused


def test_pages_show_the_same_values_when_others_close_or_reconnect(lasting, take):
    one, two = Client(lasting.url), Client(lasting.url)
    two.receive("values")
    one.request("com.weight", 2000.0)
    assert two.receive("values")["values"] == {"com.weight": 2000.0}
    one.close()
    take(1)
    two.request("gait.swing_height", 0.04)
    take(2)
    again = Client(lasting.url).receive("values")["values"]
    assert (again["com.weight"], again["gait.swing_height"]) == (2000.0, 0.04)


def test_an_infeasible_motion_is_refused_and_never_reaches_the_loop(lasting, take):
    page = Client(lasting.url)
    page.request("motion", "infeasible_motion")
    assert "no robot can do it" in page.receive("error")["error"]
    page.request("motion", "waiting")
    take(1)
    later = Client(lasting.url)
    while "infeasible_motion" not in later.receive("infeasible")["infeasible"]:
        pass  # the checks of all of them take their time


def test_a_motion_is_planned_with_its_parameters_before_the_loop_receives_it(
    lasting, take, lasting_handler
):
    page = Client(lasting.url)
    page.send(motion("squat", depth=90.0))
    assert "cannot go down by 90 %" in page.receive("error")["error"]
    page.send(motion("waiting", duration=0.2))
    take(1)
    assert lasting_handler.waiting == WaitingMotion(0.2)


def test_a_motion_that_is_being_planned_is_superseded_by_another_command(
    lasting, take, lasting_handler, tmp_path
):
    page = Client(lasting.url)
    page.send(motion("slowly_planned", folder=str(tmp_path)))
    assert page.receive("planning")["planning"] == "slowly_planned"
    page.request("stand")
    assert page.receive("planning")["planning"] is None
    take(1)
    page.send(motion("waiting", duration=0.3))  # is planned after the other one
    assert page.receive("planning")["planning"] == "waiting"
    (tmp_path / "alarm").touch()
    take(2)
    assert lasting_handler.waiting == WaitingMotion(0.3)


def test_a_motion_whose_planning_fails_is_reported_and_the_page_continues(lasting, take):
    page = Client(lasting.url)
    page.send(motion("slowly_planned", folder="nowhere"))
    assert "FileNotFoundError" in page.receive("error")["error"]
    page.send(motion("waiting", duration=0.3))
    take(1)


def test_every_command_of_a_flood_is_answered(live, handler):
    page = Client(live.url)
    for k in range(600):
        page.request("com.weight", 1000.0 + k)
    messages = []
    wait_until(
        lambda: (
            handler.before_tick(0.0)
            or messages.extend(m for m in page.received() if "outcome" in m or "error" in m)
            or len(messages) == 600
        )
    )
    accepted = [message["id"] for message in messages if "outcome" in message]
    assert len(accepted) > 1
    assert accepted == sorted(set(accepted))


def test_a_loop_that_takes_no_commands_is_reported(live):
    page = Client(live.url)
    for k in range(60):
        page.request("velocity.forward", 0.001 * k)
    assert "too many" in page.receive("error")["error"]


@pytest.mark.parametrize("ending", ["the page closes", "the page's process is killed"])
def test_a_robot_whose_last_driving_page_is_gone_stops_and_others_are_told(
    live, handler, player, ending
):
    page, other = Client(live.url), Client(live.url)
    handler.on_timeout = (told := []).append
    page.request("velocity.forward", 0.1)
    wait_until(lambda: handler.before_tick(0.0) or player.walker.velocity[0] == 0.1)
    page.close() if ending == "the page closes" else os.kill(live.pid, signal.SIGKILL)
    wait_until(lambda: handler.before_tick(0.0) or player.walker.velocity[0] == 0.0)
    assert told == ["nothing more came from the page: the robot stops and stands"]
    if ending == "the page closes":
        shown = [other.receive("values")["values"]["velocity.forward"] for _ in range(3)]
        assert shown == [0.0, 0.1, 0.0]
        assert other.receive("error") == {"error": told[0]}


def test_no_page_frames_the_page_and_it_loads_nothing_from_elsewhere(lasting):
    with urllib.request.urlopen(lasting.url, timeout=20.0) as answer:
        headers = answer.headers
    assert headers["X-Frame-Options"] == "DENY"
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert "default-src 'none'" in headers["Content-Security-Policy"]


def test_a_page_that_others_reach_is_opened_by_its_token_only(handler, caplog):
    with Live(handler, host="0.0.0.0", port=0, announce=True) as live:
        assert "whoever has its address drives the robot" in caplog.text
        address, _, token = live.url.partition("?token=")
        assert len(token) > 16
        with urllib.request.urlopen(live.url, timeout=20.0) as answer:
            cookie = answer.headers["Set-Cookie"]
        assert "HttpOnly" in cookie
        assert "SameSite=Strict" in cookie
        for headers in ({}, {"Cookie": cookie.replace(token, "x" * len(token))}):
            request = urllib.request.Request(f"{address}panel.js", headers=headers)
            with pytest.raises(urllib.error.HTTPError) as refusal:
                urllib.request.urlopen(request, timeout=20.0)
            assert refusal.value.code == 403
        request = urllib.request.Request(f"{address}panel.js", headers={"Cookie": cookie})
        with urllib.request.urlopen(request, timeout=20.0) as answer:
            assert answer.status == 200
        for path in ("controls", "socket", "alive"):
            assert Client(address, path).refused == 403
    assert not live.alive


@pytest.mark.parametrize(
    ("host", "others", "expected"),
    [("127.0.0.1", 0, False), ("127.0.0.1", 1, True), ("0.0.0.0", 0, True), ("::1", 0, False)],
)
def test_a_token_is_needed_where_others_reach_the_page(host, others, expected, monkeypatch):
    from wbc.live import address

    users = [("root", "x", 0, 0, "", "/root", "/bin/sh"), ("d", "x", 1, 1, "", "/", "/bin/false")]
    users += [("other", "x", 1001, 1001, "", "/home/other", "/bin/bash")] * others
    users += [("service", "x", 1002, 1002, "", "/", "/usr/sbin/nologin")]
    monkeypatch.setattr(address.pwd, "getpwall", lambda: [struct_passwd(user) for user in users])
    assert address.needs_token(host) is expected


@pytest.mark.parametrize("path", ["controls", "socket", "alive"])
def test_pages_of_other_origins_are_refused(lasting, path):
    assert Client(lasting.url, path, origin="http://elsewhere.example").refused == 403
    assert Client(lasting.url, path, origin="null").refused == 403
    here = lasting.url.replace("/static/", "")
    assert Client(lasting.url, path, origin=here).refused is None


@pytest.mark.parametrize(
    ("method", "headers", "code"),
    [
        ("GET", {"Host": "elsewhere.example"}, 404),
        ("POST", {}, 405),
        ("PUT", {"Origin": "http://elsewhere.example"}, 405),
    ],
)
def test_requests_with_another_host_name_or_method_are_refused(lasting, method, headers, code):
    data = b"{}" if method != "GET" else None
    request = urllib.request.Request(lasting.url, data=data, headers=headers, method=method)
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
def test_a_page_on_all_interfaces_accepts_addresses_but_not_any_host_name(listening, name, known):
    from wbc.live.address import allowed_hosts

    assert bool(re.fullmatch(allowed_hosts(listening), name)) is known


def test_the_page_loads_nothing_from_other_servers(lasting):
    def text_of(name):
        with urllib.request.urlopen(lasting.url + name, timeout=20.0) as answer:
            return answer.read().decode()

    files = re.findall(r'(?:src|href)="(\w+\.(?:js|css))"', text_of(""))
    assert {"scene.js", "panel.js", "panel.css"} <= set(files)
    for text in map(text_of, ("", *files)):
        assert len(text) > 100
        assert "http://" not in text.replace("http://www.w3.org/2000/svg", "")
        assert "https://" not in text


def test_a_port_in_use_is_refused_by_number(lasting, lasting_handler):
    port = int(lasting.url.split(":")[2].split("/")[0])
    with pytest.raises(LiveError, match=f"port {port} is in use"):
        Live(lasting_handler, port=port, announce=False)


@pytest.mark.parametrize(
    ("host", "words"),
    [
        ("no.such.name.invalid", "'no.such.name.invalid' is neither an address nor a known name"),
        ("300.1.1.1", "neither an address"),
        ("203.0.113.7", "'203.0.113.7' is not an address of this machine: give one of this"),
        ("a" * 70 + ".example", "neither an address"),
    ],
)
def test_a_host_of_another_machine_is_refused_at_once(host, words):
    from wbc.live.address import check_host

    with pytest.raises(LiveError, match=re.escape(words)):
        check_host(host)


@pytest.mark.parametrize("host", ["", "0.0.0.0", "127.0.0.1", "localhost"])
def test_addresses_of_this_machine_are_accepted(host):
    from wbc.live.address import check_host

    check_host(host)


def test_the_run_continues_and_warns_once_when_the_pages_process_dies(
    handler, monkeypatch, caplog, tmp_path
):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    live = page_of(handler)
    assert len(list(tmp_path.rglob("saved-*"))) == 1
    monkeypatch.setattr("wbc.teleop.command_handler.Clock.wait", lambda clock: None)
    monkeypatch.setattr("wbc.process.child._CHECK_PERIOD", 0.0)

    def die(now):
        if abs(now - 0.1) < 1e-9:
            os.kill(live.pid, signal.SIGKILL)
            while live.alive:
                time.sleep(0.01)

    report = wbc.teleop.run(handler, 0.2, clients=[live], before_tick=die)
    assert report.survived
    assert report.duration_s == pytest.approx(0.198)
    assert [record.message.count("the live page") for record in caplog.records] == [1]
    live.close()
    assert list(tmp_path.iterdir()) == []  # what it had saved for pages is gone, too


def test_closed_pages_leave_no_resources_open(lasting, take):
    files = Path(f"/proc/{lasting.pid}/fd")
    if not files.is_dir():
        pytest.skip("no /proc here")
    staying = Client(lasting.url)
    staying.receive("infeasible")
    before = len(list(files.iterdir()))
    for k in range(50):
        Client(lasting.url, ("controls", "socket")[k % 2]).close()
    end = time.monotonic() + 20.0
    while len(list(files.iterdir())) > before:
        assert time.monotonic() < end
        time.sleep(0.05)
    staying.request("pause", True)
    take(1)


@contextlib.contextmanager
def commanded(live, handler, duration):
    """The run on a thread; its messages on the way."""
    messages = []
    stop = threading.Event()
    thread = threading.Thread(
        target=wbc.teleop.run,
        args=(handler, duration),
        kwargs={"clients": [live], "message": messages.append, "stop": stop.is_set},
        daemon=True,
    )
    thread.start()
    yield messages
    stop.set()
    thread.join(60.0)
    assert not thread.is_alive()


def test_a_fallen_robot_is_reset_from_the_page_after_its_status_reports_the_fall(
    live, handler, monkeypatch
):
    monkeypatch.setattr("wbc.teleop.command_handler.Clock.wait", lambda clock: None)
    page = Client(live.url)

    def until(condition, ask=lambda: None):
        while not condition(status := page.receive("status")["status"]):
            ask()
        return status

    with commanded(live, handler, 1000.0) as messages:
        first = until(lambda g: g["mode"] == "running" and g["time"] > 0.1)
        assert 0.0 < first["tick_time"] < 1.0
        # Again and again: on a busy machine it may be over before a status tells of it.
        walk = functools.partial(page.request, "velocity.forward", 0.1)
        until(lambda g: g["velocity"] == [0.1, 0.0, 0.0], walk)
        page.request("push", [0.0, handler.capabilities.max_impulse])
        until(lambda g: g["mode"] == "fallen" and g["pushes"] == 1 and g["survived"] == 0)
        page.request("velocity.forward", 0.1)
        assert page.receive("error")["error"] == "the robot has fallen: reset it first"
        page.request("reset")
        until(lambda g: g["mode"] == "running")
        page.request("pause", True)
        until(lambda g: g["mode"] == "paused")
        page.request("reset")
        until(lambda g: g["mode"] == "running")
        page.request("pause", True)  # and so it ends: a run that is paused can be stopped
        until(lambda g: g["mode"] == "paused")
    said = ["the robot is falling", "fell", "reset", "reset"]
    # On a busy machine the page may fall silent for longer than a velocity lasts.
    told = [line for line in messages[1:] if not line.startswith("nothing more came")]
    assert [line.split(":")[0] for line in told] == said
    assert "press Reset (R) on the page" in told[1]


def test_the_page_receives_the_past_of_signals_and_saves_a_stretch(live, handler, tmp_path):
    page = Client(live.url)
    with commanded(live, handler, 1000.0):
        while "com: z, m" not in (offered := page.receive("signals"))["signals"]:
            pass
        assert offered["limits"]["controller_time, s"] == [None, 0.002]
        page.request("signals", ["com: z, mm"])
        assert "did you mean 'com: z, m'" in page.receive("error")["error"]
        while page.receive("status")["status"]["session"] < 0.5:
            pass
        page.request("signals", ["com: z, m", "dcm_error, m"])
        past = page.receive("past")["past"]
        points = page.receive("points")["points"]
        low, high = past["values"]["com: z, m"]
        assert low[0] == pytest.approx(handler.player.robot.com_height, rel=0.05)
        assert all(a <= b for a, b in zip(low, high, strict=True))
        assert points["time"][0] == pytest.approx(past["time"][-1] + 0.02, abs=1e-6)
        page.request("push", {"link": handler.player.robot.torso, "impulse": [0.5, 0, 0]})
        marks = []
        while "push" not in [mark["kind"] for mark in marks]:
            marks += page.receive("events")["events"]
        end = marks[-1]["time"] + 0.1
        while page.receive("status")["status"]["session"] < end + 0.1:
            pass
        page.request("save", {"as": "log", "from": -math.inf, "to": 1})
        page.request("save", {"as": "log", "from": 0, "to": end})
        assert "out of range" in page.receive("error")["error"]
        address = page.receive("saved")["saved"]
        with urllib.request.urlopen(live.url.replace("static/", address)) as answer:
            found = answer.read()
    path = tmp_path / "stretch.mcap"
    path.write_bytes(found)
    run = LoggedRun.read(path)
    assert np.diff(run.time) == pytest.approx(0.02)
    assert "push" in [event.name for event in run.events]
    assert run["dcm_error"][0] < 0.01


def test_the_present_tick_is_explained_to_a_page_though_nothing_is_logged(live, handler):
    page = Client(live.url)
    with commanded(live, handler, 1000.0):
        page.receive("status")
        page.request("why", None)
        why = page.receive("why")["why"]
    assert "error" not in why
    assert "com" in [task["name"] for task in why["tasks"]]


def test_a_robot_walks_to_a_place_on_the_floor_until_its_page_says_otherwise(live, handler):
    page = Client(live.url)
    page.receive("controls")
    with commanded(live, handler, 1000.0):
        page.receive("status")
        page.request("walk_to", [0.5])
        assert "walk_to is" in page.receive("error")["error"]
        page.request("walk_to", [1.0, 0.0, None])
        assert page.receive("walk_to")["walk_to"] == [1.0, 0.0, None]
        while page.receive("status")["status"]["velocity"][0] <= 0.0:
            pass
        page.request("stand", None)
        assert page.receive("walk_to")["walk_to"] is None
        while any(page.receive("status")["status"]["velocity"]):
            pass
