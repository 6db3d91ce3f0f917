"""Ticks cross between processes by the names of their quantities: whole, cheap, and counted."""

import gc
import logging
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from logtools import random_tick, robot

from wbc.command import Status
from wbc.runtime.mode import Mode
from wbc.runtime.record import (
    CONTACTS,
    FOOTSTEPS,
    SUPPORT,
    SWING,
    TEXT,
    contact_plan_of,
    contact_wrenches_of,
    text_of,
)
from wbc.runtime.schema import Quantity, SchemaError
from wbc.runtime.snapshot import Snapshot
from wbc.runtime.stream import TickReader, TickStream
from wbc.telemetry import ContactPlan, Footstep, Telemetry


@pytest.fixture(scope="module")
def humanoid():
    return robot()


def full_tick(humanoid, time=1.25, **changes):
    rng = np.random.default_rng(round(1000 * time))
    telemetry = Telemetry(
        *(rng.normal(size=3) for _ in range(5)), heading=0.3, dcm_error=0.02, phase="left", steps=4,
        status_text="wave · left hand",
    )  # fmt: skip
    plan = ContactPlan(
        support=rng.normal(size=(6, 3)),
        footsteps=tuple(
            Footstep(("left", "right")[k % 2], rng.normal(size=3), 0.1 * k) for k in range(3)
        ),
        swing_path=rng.normal(size=(20, 3)),
    )
    tick = random_tick(humanoid, rng, time, contacts=("left_sole", "right_sole"))
    known = {"telemetry": telemetry, "contact_plan": plan, "index": 7}
    return replace(tick, **(known | changes))


def reader_of(stream):
    reader = TickReader()
    attach(reader, stream)
    return reader


def attach(reader, stream):
    link, descriptor = stream.link()
    reader.on_message(replace(link, descriptor=os.dup(descriptor)))


def assert_same_plan(a, b):
    np.testing.assert_array_equal(a.support, b.support)
    np.testing.assert_array_equal(a.swing_path, b.swing_path)
    assert [(f.side, f.yaw, *f.position) for f in a.footsteps] == [
        (f.side, f.yaw, *f.position) for f in b.footsteps
    ]


def test_every_quantity_of_a_tick_arrives_bit_by_bit(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    tick = full_tick(humanoid)
    stream.write(tick)
    record = reader.latest()
    assert record is not None
    for name, value in {
        "time": tick.time, "tick": 7, "q": tick.estimate.state.q, "v": tick.estimate.state.v,
        "tau": tick.command.tau, "acceleration": tick.command.acceleration,
        "gyro": tick.measurement.gyro, "true_q": tick.truth.q, "true_v": tick.truth.v,
        "dcm": tick.telemetry.dcm, "velocity_command": tick.telemetry.velocity,
        "foot_wrench/left_sole": tick.measurement.foot_wrenches["left_sole"],
        "dcm_error": 0.02, "steps": 4, "estimator_time": tick.estimator_time,
    }.items():  # fmt: skip
        np.testing.assert_array_equal(record[name], value, err_msg=name)
    assert text_of(record) == "wave · left hand"
    assert_same_plan(contact_plan_of(record), tick.contact_plan)
    for name, wrench in tick.command.wrenches.items():
        np.testing.assert_array_equal(contact_wrenches_of(record)[name], wrench)
    snapshot = Snapshot.of_record(record)
    assert snapshot.status is Status.OK
    assert snapshot.telemetry.phase == "left"


def test_contact_plan_stays_in_the_records_until_the_next_one(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    first = full_tick(humanoid)
    stream.write(first)
    stream.write(full_tick(humanoid, 1.3, contact_plan=None))
    assert_same_plan(contact_plan_of(reader.latest()), first.contact_plan)


def test_unknown_quantities_are_nan_or_absent(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    stream.write(full_tick(humanoid))
    bare = random_tick(humanoid, np.random.default_rng(0), 2.0, truth=False, contacts=())
    stream.write(replace(bare, contact_plan=ContactPlan()))
    record = reader.latest()
    assert np.isnan(record["true_q"]).all()
    assert np.isnan(record["dcm"]).all()
    assert contact_wrenches_of(record) == {}
    plan = contact_plan_of(record)
    assert plan.footsteps == ()
    assert len(plan.support) == len(plan.swing_path) == 0
    assert text_of(record) == ""


def test_rows_beyond_a_bound_are_left_out_of_the_record(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    plan = ContactPlan(
        support=np.ones((100, 3)),
        footsteps=tuple(Footstep("left", np.full(3, k), 0.0) for k in range(100)),
        swing_path=np.linspace(np.zeros(3), np.ones(3), 1000),
    )
    names = tuple(f"contact {k}" for k in range(CONTACTS + 3))
    tick = random_tick(humanoid, np.random.default_rng(0), 0.0, contacts=names)
    stream.write(replace(tick, contact_plan=plan, telemetry=Telemetry(status_text="ω" * 1000)))
    record = reader.latest()
    stored = contact_plan_of(record)
    assert len(stored.support) == SUPPORT
    assert [f.position[0] for f in stored.footsteps] == list(range(FOOTSTEPS))
    assert len(stored.swing_path) == SWING
    assert stored.swing_path[-1] == pytest.approx(np.ones(3))  # the whole path
    assert list(contact_wrenches_of(record)) == list(names[:CONTACTS])
    assert text_of(record) == "ω" * (TEXT // 2)


def test_an_array_of_the_wrong_size_is_refused_by_name(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    tick = full_tick(humanoid)
    wrong = replace(tick, command=replace(tick.command, tau=np.zeros(3)))
    with pytest.raises(SchemaError, match=r"command\.tau .* has shape \(3,\)"):
        stream.write(wrong)
    assert reader.latest() is None
    stream.write(tick)
    np.testing.assert_array_equal(reader.latest()["tau"], tick.command.tau)


def test_a_reader_that_lags_behind_loses_the_oldest_and_counts_them(humanoid):
    stream = TickStream(humanoid, capacity=16)
    reader = reader_of(stream)
    for k in range(40):
        stream.write(full_tick(humanoid, 0.01 * k))
    times = []
    while len(block := reader.take(5)):
        times += block["time"].tolist()
    assert times == [0.01 * k for k in range(24, 40)]
    assert reader.lost == 24


def test_a_record_that_is_being_overwritten_is_not_read(humanoid):
    stream = TickStream(humanoid, capacity=4)
    reader = reader_of(stream)
    stream.write(full_tick(humanoid))
    for _ in range(4):
        stream._ring.begin()
        stream._ring.publish()
    stream._ring.begin()  # the row of the fifth record is being written
    assert len(reader.take(10)) + len(reader.take(10)) == 3
    assert reader.lost == 2


def test_a_reader_finishes_one_stream_before_it_takes_from_the_next(humanoid):
    first, empty, second = (TickStream(humanoid, capacity=4) for _ in range(3))
    reader = reader_of(first)
    for k in range(6):
        first.write(full_tick(humanoid, 0.01 * k))
    attach(reader, empty)
    attach(reader, second)
    second.write(full_tick(humanoid, 1.0))
    times = [t for _ in range(3) for t in reader.take(3)["time"].tolist()]
    assert times == [0.02, 0.03, 0.04, 0.05, 1.0]
    assert reader.lost == 2


def test_changed_contacts_are_read_by_their_new_names(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    for names in (("left_sole", "right_sole"), ("right_sole",), ("hand", "left_sole")):
        tick = random_tick(humanoid, np.random.default_rng(0), 0.0, contacts=names)
        stream.write(tick)
        stored = contact_wrenches_of(reader.latest())
        assert list(stored) == list(names)
        for name, wrench in tick.command.wrenches.items():
            np.testing.assert_array_equal(stored[name], wrench)


def test_two_readers_read_one_stream_at_their_own_pace(humanoid):
    stream = TickStream(humanoid)
    every, latest = reader_of(stream), reader_of(stream)
    for k in range(10):
        stream.write(full_tick(humanoid, 0.01 * k))
    assert latest.latest()["time"] == 0.09
    assert latest.latest() is None
    assert len(every.take(100)) == 10


def test_a_repeated_record_changes_mode_and_time_only(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    stream.write(full_tick(humanoid))
    before = reader.latest()
    stream.repeat(Mode.FALLEN, 12.0, {"steps": 5.0})
    record = reader.latest()
    assert (record["mode"], record["wall_time"], record["steps"]) == (Mode.FALLEN, 12.0, 5)
    np.testing.assert_array_equal(record["q"], before["q"])


def test_a_declared_quantity_is_read_by_its_name(humanoid):
    power = Quantity(
        "joint_power", lambda tick: tick.command.tau * tick.estimate.state.v[6:], "joint power",
        "W", size="na",
    )  # fmt: skip
    total = Quantity("power", lambda tick: tick.command.tau @ tick.estimate.state.v[6:], "sum", "W")
    stream = TickStream(humanoid, [power, total])
    reader = reader_of(stream)
    tick = full_tick(humanoid)
    stream.write(tick)
    record = reader.latest()
    expected = tick.command.tau * tick.estimate.state.v[6:]
    np.testing.assert_array_equal(record["joint_power"], expected)
    assert record["power"] == pytest.approx(expected.sum())
    column = reader.schema.column("joint_power")
    assert column.labels == humanoid.joint_names
    assert column.label(0) == f"joint_power: {humanoid.joint_names[0]}, W"


def test_a_quantity_whose_function_fails_is_nan_and_logged_once(humanoid, caplog):
    broken = Quantity("broken", lambda tick: 1 / 0, "fails")
    stream = TickStream(humanoid, [broken])
    reader = reader_of(stream)
    with caplog.at_level(logging.ERROR):
        for _ in range(3):
            stream.write(full_tick(humanoid))
    assert np.isnan(reader.latest()["broken"])
    assert sum("broken" in record.getMessage() for record in caplog.records) == 1


def test_a_quantity_with_an_existing_name_is_refused(humanoid):
    with pytest.raises(SchemaError, match="'tau' is declared twice"):
        TickStream(humanoid, [Quantity("tau", "command.tau", "again", size="na")])


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("command.tauu", "the quantity 'own' has no source 'command.tauu'"),
        ("command.explanation", r"command\.explanation .* is '', not a number"),
    ],
)
def test_a_source_that_is_no_number_of_the_tick_is_refused_by_name(humanoid, source, words):
    stream = TickStream(humanoid, [Quantity("own", source, "a wrong path")])
    with pytest.raises(SchemaError, match=words):
        stream.write(full_tick(humanoid))


def test_a_function_as_the_source_of_a_quantity_per_sole_is_refused(humanoid):
    with pytest.raises(SchemaError, match=r"'own/{sole}' must be the path of a mapping"):
        TickStream(humanoid, [Quantity("own/{sole}", lambda tick: 0.0, "a function")])


def test_an_unknown_quantity_is_refused_with_a_suggestion(humanoid):
    stream = TickStream(humanoid)
    with pytest.raises(SchemaError, match=r"'joint_postion'.*joint_position"):
        stream.schema.column("joint_postion")


def test_a_snapshot_written_to_a_stream_is_read_back_unchanged(humanoid):
    stream = TickStream(humanoid)
    reader = reader_of(stream)
    tick = full_tick(humanoid)
    snapshot = Snapshot.of_tick(tick, tick.contact_plan)
    stream.write(snapshot.to_tick(humanoid))
    back = Snapshot.of_record(reader.latest())
    assert (back.time, back.status, back.text) == (snapshot.time, snapshot.status, snapshot.text)
    np.testing.assert_array_equal(back.q, snapshot.q)
    np.testing.assert_array_equal(back.telemetry.zmp, snapshot.telemetry.zmp)
    assert_same_plan(back.contact_plan, snapshot.contact_plan)
    for name, wrench in snapshot.wrenches.items():
        np.testing.assert_array_equal(back.wrenches[name], wrench)


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="no /proc here")
def test_an_unreferenced_stream_closes_its_descriptor(humanoid):
    before = len(list(Path("/proc/self/fd").iterdir()))
    for _ in range(3):
        TickStream(humanoid, capacity=4).write(full_tick(humanoid))
    gc.collect()
    assert len(list(Path("/proc/self/fd").iterdir())) == before
