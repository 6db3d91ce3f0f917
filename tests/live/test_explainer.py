"""The page is told why a tick is what it is, from the tick's record alone."""

import numpy as np
import pytest

import wbc
from wbc.live.explainer import TickExplainer
from wbc.live.history import PERIOD, History
from wbc.runtime.controller_inputs import NAME, controller_inputs
from wbc.runtime.quantities import QUANTITIES
from wbc.runtime.schema import Schema, declared_columns


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


def record(robot, lift, exact):
    """The record of a tick in which the CoM is to rise faster than the legs can lift it."""
    controller = wbc.WholeBodyController(robot)
    controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
    controller.add(wbc.ComTask(priority=0 if exact else 1)).acceleration[2] = lift
    controller.add(wbc.PostureTask(robot, weight=0.01))
    state = robot.standing()
    command = controller.step(state)
    words = command.source.packed_inputs(command, 2000).copy()
    return {"time": 1.5, "q": state.q, "v": state.v, NAME: words}, command


def test_limits_in_the_way_of_a_task_are_named_with_what_they_cost(robot):
    tick, command = record(robot, lift=300.0, exact=False)
    found = TickExplainer(robot).explain(tick)
    assert found["time"] == 1.5
    label, asked, got, unit = found["tasks"][0]["rows"][0]
    assert (label, asked, unit) == ("z", 300.0, "m/s²")
    assert got < asked
    limit, expected = found["limits"][0], command.explain().active[0]
    assert limit["name"] == expected.name
    assert limit["cost"] == pytest.approx(expected.multiplier, rel=1e-2)
    assert limit["gains"][0][0].startswith("com")


def test_rows_in_conflict_are_named(robot):
    tick, command = record(robot, lift=-30.0, exact=True)
    found = TickExplainer(robot).explain(tick)
    assert found["reason"] == command.explanation
    assert any("normal force" in row for row in found["conflict"])


def test_a_tick_without_a_qp_is_answered_with_the_reason(robot):
    tick, _ = record(robot, lift=1.0, exact=False)
    tick[NAME] = np.full(2000, np.nan)
    assert "comes from no QP" in TickExplainer(robot).explain(tick)["error"]


def test_a_tick_that_is_kept_in_the_history_is_explained_like_the_present_one(robot):
    tick, _ = record(robot, lift=300.0, exact=False)
    inputs = controller_inputs(robot)
    columns = declared_columns(robot, (*QUANTITIES, inputs))
    schema = Schema(tuple(column for column, _ in columns))
    records = np.zeros(300, schema.dtype)
    records["time"], records["run"] = PERIOD * np.arange(300), 1
    for name in ("q", "v"):
        records[name] = tick[name]
    records[NAME] = tick[NAME][: records[NAME].shape[1]]
    history = History(robot, PERIOD)
    history.add(records, schema)
    explainer = TickExplainer(robot)
    kept, present = (explainer.explain(one) for one in (history.record_at(1.5), tick))
    assert kept == present
