"""The benchmarks of the loop and of the start: what they make of stamps, and that they run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).parents[2] / "benchmarks"


@pytest.fixture(scope="module")
def lateness():
    sys.path.insert(0, str(FOLDER))
    try:
        from shared import replay
    finally:
        sys.path.remove(str(FOLDER))
    return replay.lateness


def bench(script: str, *flags: str) -> str:
    done = subprocess.run(
        [sys.executable, str(FOLDER / script), *flags], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_ticks_on_schedule_are_not_late(lateness):
    assert lateness(5.0 + 0.002 * np.arange(100), 0.002) == pytest.approx(0.0, abs=1e-9)


def test_lateness_of_a_tick_equals_its_delay(lateness):
    held_up = np.zeros(100)
    held_up[[0, 40, 41]] = 1e-3, 3e-3, 1e-4  # the first one, too
    assert lateness(0.002 * np.arange(100) + held_up, 0.002) == pytest.approx(held_up, abs=1e-9)


def test_schedule_restarts_after_a_long_delay(lateness):
    asked = 0.002 * np.arange(100)
    asked[50:] += 0.1
    late = lateness(asked, 0.002)
    assert late[50] == pytest.approx(0.1)
    assert np.delete(late, 50) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.slow
def test_loop_benchmark_measures_every_observer(tmp_path):
    out, plot = tmp_path / "loop.json", tmp_path / "loop.png"
    flags = ["--robot", "simple_humanoid", "--rate", "500", "--duration", "0.4"]
    flags += ["--only", "idle", "--only", "no priority + viewer"]
    text = bench("loop.py", *flags, "--json", str(out), "--plot", str(plot))
    cells = json.loads(out.read_text())["cells"]
    assert {name for cell in cells for name in cell["observers"]} == {"viewer", "log"}
    for cell in cells:
        assert cell["ticks"] == 200
        assert 0.0 <= cell["late_p50_us"] <= cell["late_p99_us"] <= cell["late_max_us"]
        assert cell["name"] in text
        assert cell["conditions"] in text
    walking = [cell["work_p50_us"] for cell in cells if cell["walker"]]
    idle = [cell["work_p50_us"] for cell in cells if not cell["walker"]]
    assert min(walking) > max(idle)
    assert plot.stat().st_size > 10_000


@pytest.mark.slow
def test_startup_benchmark_measures_every_row(tmp_path):
    out = tmp_path / "startup.json"
    flags = ["--robot", "simple_humanoid", "--repeat", "1", "--json", str(out)]
    flags += ["--only", "import", "--only", "load"]  # kernels take long to compile
    text = bench("startup.py", *flags)
    rows = {row["what"]: row for row in json.loads(out.read_text())["rows"]}
    assert rows["import pinocchio"]["ratio"] == 1.0
    core = rows["import wbc, all of its core"]  # four times as much, on a busy machine too
    assert core["cpu_s"] > rows["import numpy"]["cpu_s"] > 0.0
    assert 0.0 < rows['wbc.load("simple_humanoid")']["part_cpu_s"] < 60.0
    assert all(name in text for name in rows)
