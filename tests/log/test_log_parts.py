"""Parts of logs: spans of time, and the timeline that holds only what is shown."""

import math
from dataclasses import replace

import numpy as np
import pytest
from logtools import StreamedLog, contact_plan, random_tick, robot, telemetry

from wbc.cli import main
from wbc.log import Log, LogError, LoggedRun, LoggedTimeline, TimeSpan
from wbc.runtime.event import RunEvent

_TICKS = 120


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A log of 12 s with a reset in the middle."""
    path = tmp_path_factory.mktemp("parts") / "long.mcap"
    humanoid, rng = robot(), np.random.default_rng(5)
    with StreamedLog(path, humanoid) as log:
        log.stream.begin_run()
        log.begin()
        for k in range(_TICKS):
            tick = random_tick(humanoid, rng, 0.1 * k)
            log.record(replace(tick, telemetry=telemetry(rng), contact_plan=contact_plan(rng)))
        log.log.on_event(RunEvent(6.0, "reset"))
    return path


def test_a_part_of_a_run_has_the_ticks_of_its_span(path):
    whole, part = LoggedRun.read(path), LoggedRun.read(path, TimeSpan(3.05, 7.0))
    chosen = (whole.time >= 3.05) & (whole.time <= 7.0)
    np.testing.assert_array_equal(part.time, whole.time[chosen])
    for name in ("q", "tau", "com"):
        np.testing.assert_array_equal(part[name], whole[name][chosen])
    assert part.title.startswith(f"{whole.robot_info.name}, 3.1 s to 7.0 s")


def test_a_part_read_by_its_place_equals_one_read_from_the_beginning(path):
    span = TimeSpan(2.0, 4.0)
    one, other = Log(path, span=span), Log(path, topics=()).between(span)
    assert one.topics.keys() == other.topics.keys()
    for name, table in one.topics.items():
        assert table.messages() == other[name].messages()
    assert [*Log(path).between(span, ("/odom",)).topics] == ["/odom"]


def test_a_span_without_ticks_is_an_error_that_names_it(path, capsys):
    with pytest.raises(LogError, match="holds no tick from 20 s to the end"):
        LoggedRun.read(path, TimeSpan(20.0))
    assert main(["plot", str(path), "--from", "5", "--to", "4"]) == 2
    assert "from 5 s to 4 s must end later" in capsys.readouterr().err


def test_the_timeline_of_a_long_log_shows_what_the_whole_run_shows(path):
    whole, timeline = LoggedRun.read(path), LoggedTimeline(path)
    assert (timeline.start, timeline.end) == (whole.start, whole.end)
    for time in (-1.0, 0.0, 11.9, 50.0, 3.95, 4.0, 8.04, 6.1):  # in any order
        one, other = whole.at(time), timeline.at(time)
        assert (one.time, one.run, one.status) == (other.time, other.run, other.status)
        np.testing.assert_array_equal(one.q, other.q)
        np.testing.assert_array_equal(one.telemetry.dcm, other.telemetry.dcm)
        np.testing.assert_array_equal(one.contact_plan.support, other.contact_plan.support)
        assert one.wrenches.keys() == other.wrenches.keys()


def test_reading_reports_its_progress_up_to_the_end(path):
    shares = []
    Log(path, progress=shares.append)
    assert shares == sorted(shares)
    assert 0.5 < shares[-1] <= 1.0
    assert all(map(math.isfinite, shares))
