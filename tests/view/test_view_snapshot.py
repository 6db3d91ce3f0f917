"""Snapshots cross between processes unchanged, cheaply, and never torn."""

import logging

import numpy as np
import pytest

import wbc
from wbc.command import Status
from wbc.errors import StateError
from wbc.telemetry import Footstep, Telemetry
from wbc.view import Snapshot, ViewerError
from wbc.view.ring import SLOTS, Ring
from wbc.view.slot import CONTACTS, FOOTSTEPS, SUPPORT, SWING, TEXT, Layout, Slot


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


@pytest.fixture
def slot(robot):
    layout = Layout.of(robot.model)
    return Slot(layout, bytearray(layout.nbytes))


def full_snapshot(robot, time=1.25, steps=3):
    rng = np.random.default_rng(0)
    telemetry = Telemetry(
        com=rng.normal(size=3),
        dcm=rng.normal(size=3),
        dcm_reference=rng.normal(size=3),
        zmp=rng.normal(size=3),
        support=rng.normal(size=(6, 3)),
        footsteps=tuple(
            Footstep(("left", "right")[k % 2], rng.normal(size=3), 0.1 * k) for k in range(steps)
        ),
        swing_path=rng.normal(size=(20, 3)),
        phase="left",
    )
    wrenches = {"left_sole": rng.normal(size=6), "right_sole": rng.normal(size=6)}
    text = "0.30 m/s · tick 0.4 ms"
    return Snapshot(time, robot.q_nominal, wrenches, telemetry, Status.INFEASIBLE, text)


def assert_same(a, b):
    assert (a.time, a.status, a.text) == (b.time, b.status, b.text)
    np.testing.assert_array_equal(a.q, b.q)
    assert list(a.wrenches) == list(b.wrenches)
    for name in a.wrenches:
        np.testing.assert_array_equal(a.wrenches[name], b.wrenches[name])
    s, t = a.telemetry, b.telemetry
    for name in ("com", "dcm", "dcm_reference", "zmp", "support", "swing_path"):
        np.testing.assert_array_equal(getattr(s, name), getattr(t, name))
    assert s.phase == t.phase
    assert [(f.side, f.yaw, *f.position) for f in s.footsteps] == [
        (f.side, f.yaw, *f.position) for f in t.footsteps
    ]


def test_a_full_snapshot_comes_back_unchanged(robot, slot):
    snapshot = full_snapshot(robot)
    slot.write(snapshot)
    assert_same(slot.read(), snapshot)


def test_an_empty_snapshot_after_a_full_one_is_empty(robot, slot):
    slot.write(full_snapshot(robot))
    slot.write(Snapshot(2.0, robot.q_nominal))
    back = slot.read()
    assert back.wrenches == {}
    assert back.telemetry.footsteps == ()
    assert len(back.telemetry.support) == len(back.telemetry.swing_path) == 0
    assert np.isnan(back.telemetry.dcm).all()
    assert back.text == ""


def test_what_exceeds_a_cap_is_left_out(robot, slot):
    many = Telemetry(
        support=np.ones((100, 3)),
        footsteps=tuple(Footstep("left", np.full(3, k), 0.0) for k in range(100)),
        swing_path=np.ones((1000, 3)),
    )
    names = [frame.name for frame in robot.model.frames][: CONTACTS + 3]
    wrenches = {name: np.zeros(6) for name in names}
    slot.write(Snapshot(0.0, robot.q_nominal, wrenches, many, text="ω" * 1000))
    back = slot.read()
    assert len(back.telemetry.support) == SUPPORT
    assert len(back.telemetry.swing_path) == SWING
    assert [f.position[0] for f in back.telemetry.footsteps] == list(range(FOOTSTEPS))
    assert len(back.wrenches) == CONTACTS
    assert back.text == "ω" * (TEXT // 2)


def test_a_contact_that_is_no_frame_is_left_out_and_said_once(robot, slot, caplog):
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            slot.write(Snapshot(0.0, robot.q_nominal, {"nose": np.ones(6)}))
    assert slot.read().wrenches == {}
    assert sum("nose" in record.getMessage() for record in caplog.records) == 1


def test_a_configuration_of_the_wrong_size_is_refused(slot):
    with pytest.raises(StateError, match=r"snapshot\.q has shape \(3,\)"):
        slot.write(Snapshot(0.0, np.zeros(3)))


def test_telemetry_of_the_wrong_shape_is_refused(robot, slot):
    with pytest.raises(ViewerError, match="cannot be shown"):
        slot.write(Snapshot(0.0, robot.q_nominal, telemetry=Telemetry(dcm=np.zeros(2))))


def test_the_reader_gets_the_latest_once(robot):
    layout = Layout.of(robot.model)
    writer = Ring(layout)
    reader = Ring(layout, writer.descriptor)
    assert reader.read() is None
    for k in range(3 * SLOTS):
        writer.write(full_snapshot(robot, time=float(k)))
    assert_same(reader.read(), full_snapshot(robot, time=3.0 * SLOTS - 1))
    assert reader.read() is None
    writer.close()


def test_a_slot_that_is_being_written_is_not_read(robot):
    layout = Layout.of(robot.model)
    writer = Ring(layout)
    reader = Ring(layout, writer.descriptor)
    writer.write(full_snapshot(robot))
    writer._records._sequence += SLOTS - 1
    writer._records.begin()  # the next round has begun to overwrite it
    assert reader.read() is None
    writer.close()


def test_a_refused_snapshot_leaves_the_ring_usable(robot):
    layout = Layout.of(robot.model)
    ring = Ring(layout)
    reader = Ring(layout, ring.descriptor)
    with pytest.raises(StateError):
        ring.write(Snapshot(0.0, np.zeros(3)))
    assert reader.read() is None
    ring.write(full_snapshot(robot))
    assert_same(reader.read(), full_snapshot(robot))
    ring.close()
