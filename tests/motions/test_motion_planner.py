"""Planning outside the loop: a plan that takes for ever delays no other."""

import os
import threading

import pytest
from processtools import wait_until

import wbc
from wbc.errors import MotionError
from wbc.motions import Squat, Wave
from wbc.motions.engine.planning import MotionPlanner, PlannedMotion
from wbc.motions.keyframing import read_keyframes


def test_a_blocked_plan_is_abandoned_and_delays_no_other(monkeypatch):
    started, blocked, done = threading.Event(), threading.Event(), []

    def plan(_, motion):
        if motion == Squat():
            started.set()
            blocked.wait(20.0)
        return PlannedMotion(motion, b"plan", "")

    monkeypatch.setattr(MotionPlanner, "_plan", plan)
    planner = MotionPlanner(wbc.load("simple_humanoid"), (), done.append)
    planner.start()
    planner.request(Squat())
    assert started.wait(20.0)
    planner.abandon()
    planner.request(Wave())
    wait_until(lambda: [one.motion for one in done] == [Wave()])
    blocked.set()
    planner.request(Wave(seconds=2.0))
    wait_until(lambda: [one.motion for one in done] == [Wave(), Wave(seconds=2.0)])


def test_a_keyframe_file_that_is_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe.csv")
    with pytest.raises(MotionError, match="is not a regular file"):
        read_keyframes(tmp_path / "pipe.csv")
