"""The real-time loop: what it asks the system for, that it says so, and that it gives it back."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import wbc
from wbc.errors import WbcError
from wbc.runtime.clock import Clock
from wbc.runtime.loop_conditions import LoopConditions, SystemRequest
from wbc.runtime.real_time import RealTime, garbage_collection_paused, real_time_thread

linux = pytest.mark.skipif(sys.platform != "linux", reason="asks Linux")


def system_state() -> dict[str, object]:
    """Everything that a real-time run may change, as it is now."""
    state: dict[str, object] = {
        "switch interval": sys.getswitchinterval(),
        "collector": (gc.isenabled(), gc.get_freeze_count()),
    }
    if sys.platform == "linux":
        status = Path("/proc/self/status").read_text().splitlines()
        state["locked"] = [line for line in status if line.startswith("VmLck")]
        state["policy"] = os.sched_getscheduler(0)
        state["priority"] = os.sched_getparam(0).sched_priority
        state["nice"] = os.getpriority(os.PRIO_PROCESS, 0)
        state["processors"] = os.sched_getaffinity(0)
        state["slack"] = Path("/proc/self/timerslack_ns").read_text()
    return state


def refuse(*_: object) -> None:
    raise PermissionError(1, "Operation not permitted")


class Still:
    """Controller and plant in one: a robot that stands, whatever happens."""

    def __init__(self, robot: wbc.Robot) -> None:
        self.robot, self.dt, self.time, self.seen = robot, 0.002, 0.0, None
        na = robot.na
        zero = np.zeros(na)
        self._command = wbc.Command(zero, np.zeros(robot.nv), {}, zero, zero)

    def reset(self, state: wbc.State) -> None:
        self._state = state

    def ground_truth(self) -> wbc.State:
        return self.robot.standing()

    def measure(self) -> wbc.Measurement:
        na = self.robot.na
        up = np.array([0.0, 0.0, 9.81])
        return wbc.Measurement(
            self.time, self.robot.q_nominal[7:], np.zeros(na), np.zeros(3), up, {}, self._state
        )

    def step(self, given: object) -> wbc.Command:
        if isinstance(given, wbc.Command):
            self.time += self.dt
        else:
            self.seen = system_state()
        return self._command


@pytest.fixture(scope="module")
def robot() -> wbc.Robot:
    return wbc.load("simple_humanoid")


def run(robot: wbc.Robot, **options: object) -> tuple[wbc.Report, Still]:
    still = Still(robot)
    estimator = wbc.GroundTruthEstimator(robot)
    return wbc.run(still, still, 0.02, estimator=estimator, **options), still


def test_system_settings_are_restored_after_a_run(robot):
    before = system_state()
    _, still = run(robot, real_time=True)
    assert still.seen is not None
    assert still.seen["switch interval"] == pytest.approx(2e-4)
    assert still.seen["collector"][0] is False
    assert still.seen != before
    assert system_state() == before


def test_system_settings_are_restored_after_an_error_in_mid_tick(robot):
    before = system_state()

    def trip(_: float) -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run(robot, real_time=True, before_tick=trip)
    assert system_state() == before


def test_run_not_in_real_time_only_pauses_garbage_collection(robot, capsys):
    before = system_state()
    report, still = run(robot)
    assert {k for k in before if still.seen[k] != before[k]} == {"collector"}
    assert report.loop_conditions == ""
    assert capsys.readouterr().err == ""


def test_loop_conditions_are_reported_before_the_first_tick_and_in_the_report(robot):
    told: list[tuple[LoopConditions, float]] = []
    still = Still(robot)
    report = wbc.run(
        still,
        still,
        0.02,
        estimator=wbc.GroundTruthEstimator(robot),
        real_time=True,
        on_conditions=lambda conditions: told.append((conditions, still.time)),
    )
    assert len(told) == 1
    conditions, when = told[0]
    assert when == 0.0
    assert report.loop_conditions == conditions.describe()
    assert len(conditions.granted) + len(conditions.refused) == len(conditions.requests)


def test_loop_conditions_are_printed_to_standard_error_by_default(robot, capsys):
    report, _ = run(robot, real_time=True)
    shown = capsys.readouterr()
    assert shown.err == report.loop_conditions + "\n"
    assert shown.out == ""


@linux
def test_refused_requests_are_reported_with_their_cure_and_the_run_continues(robot, monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})  # with one it is not asked for
    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    monkeypatch.setattr(os, "setpriority", refuse)
    monkeypatch.setattr(os, "getpriority", lambda *_: 0)
    told: list[LoopConditions] = []
    report, _ = run(robot, real_time=True, on_conditions=told.append)
    assert report.survived
    assert {"SCHED_FIFO 40", "nice -20"} <= set(told[0].refused)
    assert "rtprio 40" in report.loop_conditions
    # What needs no permission comes in its place.
    assert "timer slack 1 ns" in told[0].granted


@linux
def test_real_time_priority_is_refused_on_a_single_processor(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
    policy = os.sched_getscheduler(0)
    with real_time_thread(RealTime(40)) as conditions:
        assert os.sched_getscheduler(0) == policy
    assert "SCHED_FIFO 40" in conditions.refused


@linux
def test_a_niced_process_gets_no_real_time_priority_unless_it_asks_for_one(monkeypatch):
    monkeypatch.setattr(os, "getpriority", lambda *_: 5)
    asked = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda *given: asked.append(given))
    with real_time_thread(RealTime()) as conditions:
        assert asked == []
    assert "SCHED_FIFO 40 (the process has nice 5" in conditions.describe()
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    with real_time_thread(RealTime(30)) as conditions:
        assert asked
    assert "SCHED_FIFO 30" in conditions.granted


@linux
def test_priority_and_memory_lock_are_not_requested_when_disabled():
    before = system_state()
    with real_time_thread(
        RealTime(priority=0, lock_memory=False, switch_interval=0.001)
    ) as conditions:
        during = system_state()
    changed = {k for k in before if during[k] != before[k]}
    assert changed <= {"switch interval", "slack"}
    assert during["switch interval"] == pytest.approx(0.001)
    assert conditions.refused == ()


@linux
def test_processes_that_the_loop_starts_have_ordinary_priority():
    with real_time_thread(RealTime(40)) as conditions:
        if "SCHED_FIFO 40" not in conditions.granted:
            pytest.skip("no permission for real-time priority")
        assert os.sched_getparam(0).sched_priority == 40
        code = "import os; print(os.sched_getscheduler(0), os.getpriority(os.PRIO_PROCESS, 0))"
        child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert child.stdout.split()[0] == str(os.SCHED_OTHER)
    assert int(child.stdout.split()[1]) >= 0


def test_disabled_or_frozen_garbage_collection_stays_so_after_a_run():
    gc.disable()
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with garbage_collection_paused():
            assert not gc.isenabled()
        assert not gc.isenabled()
        assert gc.get_freeze_count() == frozen
    finally:
        gc.unfreeze()
        gc.enable()


@pytest.mark.parametrize("wrong", [{"priority": 100}, {"priority": -1}, {"switch_interval": 0.0}])
def test_invalid_real_time_settings_are_refused_by_name(wrong):
    with pytest.raises(WbcError, match=next(iter(wrong))):
        RealTime(**wrong)


def test_description_of_loop_conditions_names_refusals_and_reasons():
    conditions = LoopConditions(
        (SystemRequest("a", True), SystemRequest("b", False, "needs c"), SystemRequest("d", False))
    )
    assert conditions.describe() == "real-time loop: a; refused: b (needs c), d"


def test_clock_never_begins_a_period_early():
    dt, begun = 0.001, time.perf_counter()
    clock = Clock(dt, 100)
    for k in range(100):
        clock.wait()
        assert time.perf_counter() >= begun + k * dt
    assert clock.lateness.shape == (100,)
    assert (clock.lateness >= 0.0).all()


def test_clock_counts_a_delay_and_does_not_shorten_later_periods():
    dt = 0.001
    clock = Clock(dt, 10)
    clock.wait()
    time.sleep(0.05)  # 50 periods
    begun = time.perf_counter()  # before the wait: after it a short hold-up would be caught up
    for _ in range(4):
        clock.wait()
    assert clock.overruns >= 1
    assert clock.lateness[1] > 0.04
    assert time.perf_counter() - begun >= 3.0 * dt
