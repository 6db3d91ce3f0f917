"""The benchmark of the closed loop keeps running, keeps its keys, and its parts add up."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("mujoco")

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "closed_loop.py"


def test_the_closed_loop_benchmark_prints_a_table_and_writes_json(tmp_path):
    out = tmp_path / "out" / "closed_loop.json"
    flags = ["--robot", "simple_humanoid", "--duration", "1", "--rounds", "1", "--json", str(out)]
    done = subprocess.run(
        [sys.executable, str(SCRIPT), *flags], capture_output=True, text=True, check=True
    )
    assert "| simple_humanoid |" in done.stdout
    row = json.loads(out.read_text())["simple_humanoid"]
    stages = ("plant", "estimator", "gait_and_balance", "controller", "loop")
    assert all(row[f"{stage}_p50_us"] > 0.0 for stage in stages)
    parts = sum(row[f"{stage}_mean_us"] for stage in stages)
    assert parts == pytest.approx(row["period_mean_us"], rel=1e-6)
    assert row["command_over_controller"] > 1.0
    assert row["real_time_factor"] > 0.0
