"""Diagnostics of runs that follow one another."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import wbc
from wbc.runtime.schema import Quantity
from wbc.runtime.stream import TickStream

pytest.importorskip("cyclonedds")


def test_runs_with_other_quantities_are_counted_together():
    from wbc.ros.bridge.diagnostics import Diagnostics
    from wbc.ros.bridge.stamped_tick import StampedTick

    robot, published = wbc.load("simple_humanoid"), []
    node = SimpleNamespace(
        fully_qualified_name="/wbc",
        create_publisher=lambda *_: SimpleNamespace(publish=published.append),
        declare_parameter=lambda *_, **__: SimpleNamespace(value=1.0),
    )
    diagnostics = Diagnostics(node, SimpleNamespace(robot=robot, dt=0.002))
    own = Quantity("power", lambda tick: 0.0, "mechanical power", "W")
    for run, quantities in enumerate(((), (own,)), 1):
        records = np.zeros(300, TickStream(robot, quantities).schema.dtype)
        records["wall_time"] = 1.0 + 0.6 * run + 0.002 * np.arange(300)
        records["run"], records["period"], records["controller_time"] = run, 0.002, 1e-4 * run
        for tick in StampedTick.from_records(records):
            diagnostics.on_tick(tick)
    assert len(published) == 2
    values = {pair.key: pair.value for pair in published[-1].status[0].values}
    assert values["rate (Hz)"] == "500.0"
    assert (values["tick p50 (µs)"], values["tick max (µs)"]) == ("100", "200")
    assert values["resets"] == "1"
