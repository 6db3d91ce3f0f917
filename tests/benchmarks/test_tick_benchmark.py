"""The benchmark of the tick keeps running and keeps its keys."""

import json
import subprocess
import sys
from pathlib import Path

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "tick.py"


def test_the_tick_benchmark_prints_a_table_and_writes_json(tmp_path):
    out = tmp_path / "tick.json"
    flags = ["--duration", "1.6", "--repeat", "1", "--breakdown", "--json", str(out)]
    done = subprocess.run(
        [sys.executable, str(SCRIPT), *flags], capture_output=True, text=True, check=True
    )
    assert "kinematics" in done.stdout
    found = json.loads(out.read_text())
    assert found["robot"] == "talos"
    for support in ("single", "double"):
        parts = sum(found[support][f"{s}_us"] for s in ("kinematics", "assembly", "solve"))
        assert 0.0 < parts < 2.0 * found[support]["p50_us"]
