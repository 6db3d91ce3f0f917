"""The ramp: its faces meet floor and plateau, in the physics as in the viewer."""

from __future__ import annotations

import math

import numpy as np
import pytest
from simtools import robot

from wbc.errors import PlantError
from wbc.sim import Mujoco, Ramp
from wbc.view.terrain import box_mesh, checked_boxes

mujoco = pytest.importorskip("mujoco")

RAMP = Ramp(math.radians(10.0), length=2.0, plateau=1.0, distance=0.5)


def height(plant: Mujoco, x: float) -> float:
    """Height of the ground at a place in front of the robot, by a ray from above, m."""
    plant.data.qpos[2] = 50.0  # out of the way
    mujoco.mj_forward(plant.model, plant.data)
    down = np.array([0.0, 0.0, -1.0])
    hit = np.zeros(1, dtype=np.int32)
    start = np.array([x, 0.1, 5.0])
    return 5.0 - float(mujoco.mj_ray(plant.model, plant.data, start, down, None, 1, -1, hit))


def test_ramp_rises_to_its_plateau_and_falls_to_the_floor() -> None:
    run, rise = 2.0 * math.cos(RAMP.angle), 2.0 * math.sin(RAMP.angle)
    with Mujoco(robot("talos"), terrain=RAMP) as plant:
        expected = {
            0.3: 0.0,
            0.5 + 0.25 * run: 0.25 * rise,
            0.5 + 0.99 * run: 0.99 * rise,
            0.5 + run + 0.5: rise,
            0.5 + run + 1.0 + 0.5 * run: 0.5 * rise,
            0.5 + run + 1.0 + run + 0.2: 0.0,
        }
        for x, z in expected.items():
            assert height(plant, x) == pytest.approx(z, abs=1e-6)


def test_viewer_draws_the_ramp_where_the_physics_has_it() -> None:
    boxes = checked_boxes(RAMP.boxes())
    vertices = np.asarray(box_mesh(boxes).vertices).reshape(3, 8, 3)
    with Mujoco(robot("talos"), terrain=RAMP) as plant:
        body = plant.model.body("terrain").id
        for geom, corners in zip(
            np.flatnonzero(plant.model.geom_bodyid == body), vertices, strict=True
        ):
            turned = plant.data.geom_xmat[geom].reshape(3, 3)
            local = (corners - plant.data.geom_xpos[geom]) @ turned
            np.testing.assert_allclose(
                np.abs(local), np.tile(plant.model.geom_size[geom], (8, 1)), atol=1e-9
            )


def test_invalid_ramps_are_refused() -> None:
    with pytest.raises(PlantError, match="Ramp: length is 0"):
        Ramp(length=0.0)
    with pytest.raises(PlantError, match="angle is 1"):
        Ramp(angle=1.0)
