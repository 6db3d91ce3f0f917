"""Whatever is killed, cut or full: the run goes on, and the log can be read up to the end."""

import contextlib
import logging
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from logtools import StreamedLog, random_tick, robot
from processtools import gone, wait_until

import wbc
from wbc.log.errors import LogError
from wbc.log.reader import Log
from wbc.log.recovery import complete, repair
from wbc.log.run import LoggedRun
from wbc.log.time_span import TimeSpan
from wbc.messages import message_type
from wbc.process import ChildProcess, ProcessStartError

ROOT = Path(wbc.__file__).parent.parent

#: Records ticks for ever, never faster than the wall clock, and says how many there were.
ENDLESS = """
import sys, time
import numpy as np
from logtools import StreamedLog, random_tick, robot
humanoid = robot()
rng = np.random.default_rng(0)
ticks = [random_tick(humanoid, rng, 0.0) for _ in range(50)]
from dataclasses import replace
log = StreamedLog(sys.argv[1], humanoid)
log.begin()
print(log.log.pid, flush=True)
k = 0
while True:
    log.record(replace(ticks[k % 50], time=0.002 * k))
    k += 1
    if k % 50 == 0:
        print(k, flush=True)
    time.sleep(0.002)
"""


@pytest.fixture(scope="module")
def humanoid():
    return robot()


@contextlib.contextmanager
def endless(path, ticks):
    """A run in a process of its own that has gone on for some ticks; its log's process."""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests' / 'tools'}"}
    process = subprocess.Popen(
        [sys.executable, "-c", ENDLESS, str(path)],
        stdout=subprocess.PIPE,
        text=True,
        env=environment,
    )
    try:
        writer = int(process.stdout.readline())
        while int(process.stdout.readline()) < ticks:
            pass
        yield process, writer
    finally:
        process.kill()
        process.wait()
        process.stdout.close()


def reference_counts(path):
    """Topic -> number of messages, by the reader of the format's makers."""
    from mcap.reader import make_reader

    counts = {}
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        for _, channel, _ in reader.iter_messages():
            counts[channel.topic] = counts.get(channel.topic, 0) + 1
        summary = reader.get_summary()
        assert summary.statistics.message_count == sum(counts.values())
        assert summary.statistics.chunk_count == len(summary.chunk_indexes)
    return counts


def own_counts(path):
    log = Log(path)
    return {topic: len(table) for topic, table in log.topics.items()}


def test_a_killed_run_leaves_a_complete_log_with_every_tick(tmp_path):
    path = tmp_path / "killed.mcap"
    with endless(path, 300) as (process, writer):
        process.send_signal(signal.SIGKILL)
        process.wait()
        ticks = [int(line) for line in process.stdout.read().split()]
        wait_until(lambda: gone(writer))
    run = LoggedRun.read(path)
    assert run.log.complete
    assert run.title.endswith(", ended without a report")
    assert len(run) >= max([300, *ticks])
    assert run["tick"].tolist() == list(range(len(run)))
    assert reference_counts(path) == own_counts(path)


def test_a_killed_writer_loses_less_than_a_second_and_the_run_continues(humanoid, tmp_path, caplog):
    rng = np.random.default_rng(0)
    path = tmp_path / "writer.mcap"
    log = StreamedLog(path, humanoid)
    log.begin()
    with caplog.at_level(logging.WARNING):
        for k in range(600):  # never faster than the wall clock
            log.record(random_tick(humanoid, rng, 0.002 * k))
            time.sleep(0.002)
        os.kill(log.log.pid, signal.SIGKILL)
        record_until_it_ends(log, humanoid)
    said = [r for r in caplog.records if "the run continues without it" in r.getMessage()]
    assert len(said) == 1
    log.close()
    run = LoggedRun.read(path)
    assert run.log.complete  # closing repaired it
    assert 1.2 - 1.0 < run.time[-1] < 1.2
    assert reference_counts(path) == own_counts(path)


def test_a_log_is_readable_up_to_its_last_second_when_both_processes_are_killed(tmp_path):
    path = tmp_path / "all.mcap"
    with endless(path, 800) as (process, writer):
        os.kill(writer, signal.SIGKILL)
        process.send_signal(signal.SIGKILL)
        process.wait()
        wait_until(lambda: gone(writer))  # it may be in the middle of a write
    broken = LoggedRun.read(path)
    assert not broken.log.complete
    assert broken.time[-1] > 1.598 - 1.0
    before = own_counts(path)
    end = complete(path)
    assert end == broken.time[-1]
    assert Log(path).complete
    assert own_counts(path) == before == reference_counts(path)
    rosbags = pytest.importorskip("rosbags.highlevel")
    with rosbags.AnyReader([path]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections} == before


@pytest.fixture(scope="module")
def whole(humanoid, tmp_path_factory):
    """A log of several chunks."""
    rng = np.random.default_rng(0)
    path = tmp_path_factory.mktemp("whole") / "whole.mcap"
    ticks = [random_tick(humanoid, rng, 0.002 * k) for k in range(90)]
    with StreamedLog(path, humanoid) as log:
        log.begin()
        for k, tick in enumerate(ticks):
            log.record(tick)
            if k in (30, 60):  # the end of a chunk
                wait_until(lambda k=k: own_counts(path).get("/controller_state") == k + 1)
    return path


def test_a_log_truncated_anywhere_can_be_read_and_repaired(whole, tmp_path):
    data = whole.read_bytes()
    last = -1
    for size in np.linspace(9, len(data) - 1, 30).astype(int):
        path = tmp_path / "cut.mcap"
        path.write_bytes(data[:size])
        counts = own_counts(path)
        total = sum(counts.values())
        assert total >= last, "more of the file holds less of the log"
        last = total
        assert not Log(path).complete
        complete(path)
        assert Log(path).complete
        assert own_counts(path) == counts == reference_counts(path)
    assert last == sum(own_counts(whole).values())


@pytest.fixture(scope="module")
def chunks(whole):
    from mcap.reader import make_reader

    with whole.open("rb") as file:
        found = make_reader(file).get_summary().chunk_indexes
    assert len(found) >= 3
    return found


def flipped(whole, tmp_path, offset):
    data = bytearray(whole.read_bytes())
    data[offset] ^= 0x10
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    return path


@pytest.mark.parametrize("damaged", [0, 1, -1])
@pytest.mark.parametrize("place", ["opcode", "length", "content"])
def test_only_a_damaged_chunk_is_missing_from_what_is_read_and_from_a_repaired_copy(
    whole, chunks, tmp_path, damaged, place
):
    chunk = chunks[damaged]
    offset = {"opcode": 0, "length": 6, "content": chunk.chunk_length // 2}[place]
    path = flipped(whole, tmp_path, chunk.chunk_start_offset + offset)
    before = path.read_bytes()
    original = Log(whole)["/controller_state"].stamps
    first, last = chunk.message_start_time, chunk.message_end_time
    expected = [t for t in original.tolist() if not first <= t <= last]
    read = Log(path)
    assert read["/controller_state"].stamps.tolist() == expected
    copy = tmp_path / "copy.mcap"
    repaired = repair(path, copy)
    assert repaired.finished
    assert path.read_bytes() == before
    assert Log(copy)["/controller_state"].stamps.tolist() == expected
    assert own_counts(copy) == own_counts(path) == reference_counts(copy)
    for gaps in (read.gaps, repaired.gaps):
        (gap,) = gaps
        assert gap.start <= 1e-9 * first
        assert gap.end >= 1e-9 * last
        assert gap.end - gap.start < 1e-9 * (last - first) + 0.005
    assert not Log(copy).gaps


def span_of(chunk):
    return TimeSpan(1e-9 * chunk.message_start_time - 1e-4, 1e-9 * chunk.message_end_time + 1e-4)


def test_chunks_beyond_a_span_are_not_read(whole, chunks, tmp_path):
    data, span = bytearray(whole.read_bytes()), span_of(chunks[1])
    for chunk in (*chunks[:1], *chunks[2:]):
        start = chunk.chunk_start_offset
        data[start : start + chunk.chunk_length] = b"\xff" * chunk.chunk_length
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    assert Log(path).gaps
    part = Log(path, span=span)
    assert not part.gaps
    assert len(part["/controller_state"]) == 30
    assert part["/odom"].messages() == Log(whole, span=span)["/odom"].messages()


def test_a_damaged_chunk_of_a_span_is_a_gap_between_its_neighbours(whole, chunks, tmp_path):
    path = flipped(whole, tmp_path, chunks[1].chunk_start_offset)
    (gap,) = Log(path, span=span_of(chunks[1])).gaps
    assert gap.start == pytest.approx(1e-9 * chunks[0].message_end_time)
    assert gap.end == pytest.approx(1e-9 * chunks[2].message_start_time)


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_a_log_of_another_program_is_read_without_a_damaged_chunk(tmp_path, compression):
    from mcap.reader import make_reader
    from mcap.writer import CompressionType, Writer

    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=CompressionType[compression])
        writer.start("ros2")
        schema = writer.register_schema("std_msgs/msg/Float64", "ros2msg", b"float64 data")
        channel = writer.register_channel("/number", "cdr", schema)
        number = message_type("std_msgs/msg/Float64")
        for k in range(60):
            writer.add_message(channel, k, number(data=0.1 * k).encode(), k)
            if k % 20 == 19:
                writer.flush()
        writer.finish()
    with path.open("rb") as file:
        damaged = make_reader(file).get_summary().chunk_indexes[1]
    data = bytearray(path.read_bytes())
    middle = damaged.chunk_start_offset + damaged.chunk_length // 2
    data[middle : middle + 4] = b"\xff" * 4
    path.write_bytes(data)
    log = Log(path)
    assert log.complete
    expected = 0.1 * np.array([*range(20), *range(40, 60)])
    np.testing.assert_array_equal(log["/number"].numbers("data")[:, 0], expected)


def test_a_damaged_log_without_an_end_is_read_past_the_damage(whole, chunks, tmp_path):
    path = flipped(whole, tmp_path, chunks[1].chunk_start_offset + 6)
    data = path.read_bytes()
    path.write_bytes(data[: chunks[2].chunk_start_offset + chunks[2].chunk_length])
    log = Log(path)
    assert not log.complete
    assert len(log["/controller_state"]) == 90 - 30
    cut = path.read_bytes()
    complete(path)  # it would take the third chunk away
    assert path.read_bytes() == cut


def test_only_an_interrupted_log_is_changed_by_its_completion(whole, tmp_path):
    path = Path(shutil.copy(whole, tmp_path))
    complete(path)
    assert path.read_bytes() == whole.read_bytes()


def test_repair_refuses_a_file_that_is_no_log_and_the_log_itself(whole, tmp_path):
    path, copy = tmp_path / "notes.txt", tmp_path / "copy.mcap"
    path.write_bytes(b"dear diary, " * 10)
    with pytest.raises(LogError, match="is not an MCAP file"):
        repair(path, copy)
    with pytest.raises(LogError, match="is not an MCAP file"):
        complete(path)
    assert path.read_bytes() == b"dear diary, " * 10
    assert not copy.exists()
    with pytest.raises(LogError, match="another file"):
        repair(whole, whole)


def test_a_failed_repair_leaves_the_former_copy_whole(whole, tmp_path, monkeypatch):
    copy = tmp_path / "copy.mcap"
    copy.write_bytes(b"former")

    def fail(_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(LogError, match="No space left"):
        repair(whole, copy)
    assert copy.read_bytes() == b"former"
    assert sorted(tmp_path.iterdir()) == [copy]


def record_until_it_ends(log, humanoid, at_most=10.0):
    """Go on recording until a while after the log has ended."""
    rng = np.random.default_rng(0)
    ticks = [random_tick(humanoid, rng, 0.0) for _ in range(20)]
    end, k = time.monotonic() + at_most, 0
    after = None
    while after is None or time.monotonic() < after:
        assert time.monotonic() < end, "the log never ended"
        tick = replace(ticks[k % 20], time=0.002 * k)
        log.record(tick)
        k += 1
        if after is None and not log.log.alive:
            after = time.monotonic() + 0.7
        time.sleep(0.0005)


def check_after_full_disk(path, caplog, said):
    told = [r.getMessage() for r in caplog.records if "the run continues without it" in r.message]
    assert len(told) == 1
    assert said in told[0]
    run = LoggedRun.read(path)
    assert run.log.complete
    assert len(run) > 100
    assert run["tick"].tolist() == list(range(len(run)))
    assert reference_counts(path) == own_counts(path)


def test_a_file_size_limit_ends_the_log_and_not_the_run(humanoid, tmp_path, caplog):
    path = tmp_path / "limited.mcap"
    log = StreamedLog(path, humanoid)
    resource.prlimit(log.log.pid, resource.RLIMIT_FSIZE, (600_000, 600_000))
    with caplog.at_level(logging.WARNING):
        record_until_it_ends(log, humanoid)
        log.close()
    check_after_full_disk(path, caplog, "File too large")


def test_a_full_disk_ends_the_log_and_not_the_run(humanoid, tmp_path, caplog):
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=600k", "wbc-test", str(disk)]
    if os.geteuid() != 0 or shutil.which("mount") is None or shutil.which("umount") is None:
        pytest.skip("only root, with mount, can make a small disk")
    if subprocess.run(mount, capture_output=True).returncode != 0:
        pytest.skip("this machine lets nobody mount a small disk")
    try:
        (disk / "full.mcap").write_bytes(b"the log of before")
        with caplog.at_level(logging.WARNING):
            log = StreamedLog(disk / "full.mcap", humanoid)
            record_until_it_ends(log, humanoid)
            log.close()
        said = caplog.text
        assert "MB left on its disk" in said
        assert f"kept as {disk / 'full.previous.mcap'}" in said
        assert (disk / "full.previous.mcap").read_bytes() == b"the log of before"
        check_after_full_disk(disk / "full.mcap", caplog, "No space left on device")
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def test_a_full_disk_is_an_error_before_the_run(humanoid):
    with pytest.raises(LogError, match="No space left on device"):
        StreamedLog("/dev/full", humanoid)


def test_a_log_replaces_the_one_of_before_when_it_is_complete(humanoid, tmp_path):
    path = tmp_path / "walk.mcap"
    path.write_bytes(b"the log of before")
    with StreamedLog(path, humanoid):
        assert (tmp_path / "walk.previous.mcap").read_bytes() == b"the log of before"
    assert [file.name for file in tmp_path.iterdir()] == ["walk.mcap"]
    assert Log(path).complete


def test_a_log_that_cannot_be_opened_leaves_the_one_of_before(humanoid, tmp_path, monkeypatch):
    path = tmp_path / "walk.mcap"
    path.write_bytes(b"the log of before")

    def fail(*_):
        raise ProcessStartError("no process can be started")

    monkeypatch.setattr(ChildProcess, "configure", fail)
    with pytest.raises(LogError, match="no process can be started"):
        StreamedLog(path, humanoid)
    assert path.read_bytes() == b"the log of before"
    assert [file.name for file in tmp_path.iterdir()] == ["walk.mcap"]


def test_a_stopped_writer_never_blocks_the_run(humanoid, tmp_path):
    rng = np.random.default_rng(0)
    tick = random_tick(humanoid, rng, 0.0)
    log = StreamedLog(tmp_path / "stopped.mcap", humanoid, capacity=100)
    os.kill(log.log.pid, signal.SIGSTOP)
    try:
        for _ in range(3000):
            log.record(tick)
    finally:
        os.kill(log.log.pid, signal.SIGCONT)
        log.close()
    assert log.log.dropped == 2900


def test_a_script_that_never_closes_its_log_leaves_it_complete(tmp_path):
    code = """
import sys
import numpy as np
from logtools import StreamedLog, random_tick, robot
humanoid = robot()
rng = np.random.default_rng(0)
log = StreamedLog(sys.argv[1], humanoid)
for k in range(40):
    log.record(random_tick(humanoid, rng, 0.002 * k))
"""
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests' / 'tools'}"}
    path = tmp_path / "left.mcap"
    command = [sys.executable, "-c", code, str(path)]
    result = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=60)
    assert (result.returncode, result.stderr) == (0, "")
    run = LoggedRun.read(path)
    assert run.log.complete
    assert len(run) == 40
