"""A robot in another size, with torques scaled as they should be, walks without a change."""

from __future__ import annotations

import math

import pytest
from robottools import FEET, SIMPLE
from scaledrobot import INERTIA, scaled_urdf

import wbc


@pytest.mark.parametrize("factor", [0.25, 0.5, 2.0])
def test_a_scaled_robot_walks_at_its_own_speed(tmp_path, factor: float) -> None:
    path = scaled_urdf(SIMPLE, factor, tmp_path / "scaled.urdf")
    robot = wbc.load(path, armature=0.01 * factor**INERTIA, **FEET)
    same_size = scaled_urdf(SIMPLE, 1.0, tmp_path / "same.urdf")
    original = wbc.Walker(wbc.load(same_size, armature=0.01, **FEET)).gait.max_velocity.forward
    walker = wbc.Walker(robot)
    limit = walker.gait.max_velocity.forward
    assert limit == pytest.approx(math.sqrt(factor) * original, rel=0.05)
    speed, time = 0.5 * limit, 3.0 * math.sqrt(factor)

    def command(now: float) -> None:
        walker.velocity = (speed, 0.0, 0.0) if 0.5 <= now < 0.5 + time else (0.0, 0.0, 0.0)

    mujoco = pytest.importorskip("wbc.sim")
    plant = mujoco.Mujoco(robot)
    report = wbc.run(walker, plant, 0.5 + 1.5 * time, before_tick=command)
    assert report.survived, report.fell_why
    assert report.displacement_m[0] > 0.5 * speed * time
    assert report.torque_excess_nm <= 0.0
