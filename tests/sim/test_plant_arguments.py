"""Arguments of the plant that make no sense are refused, with value and cure."""

from __future__ import annotations

import numpy as np
import pytest
from simtools import command, robot

from wbc.errors import PhysicsDiverged, PlantError
from wbc.sim import Mujoco, SensorNoise
from wbc.state import State

pytest.importorskip("mujoco")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"friction": -1.0}, "friction = -1"),
        ({"friction": np.nan}, "friction = nan"),
        ({"dt": 0.0025}, r"dt = 0\.0025 s must be a whole number of timesteps of 0\.001 s"),
        ({"dt": 0.0}, "dt = 0"),
        ({"dt": np.inf}, "dt = inf"),
        ({"timestep": -0.001}, "timestep = -0.001"),
        ({"latency": 0.0005}, "latency = 0.0005"),
        ({"latency": -0.001}, "latency = -0.001"),
        ({"seed": -1}, "seed = -1"),
        ({"seed": 0.5}, "seed = 0.5"),
    ],
)
def test_invalid_arguments_are_refused_with_name_and_value(arguments, message):
    with pytest.raises(PlantError, match=message):
        Mujoco(robot(), **arguments)


def test_negative_deviations_of_sensors_are_refused():
    with pytest.raises(PlantError, match="encoder = -1"):
        SensorNoise(encoder=-1.0)
    with pytest.raises(PlantError, match="gyro = nan"):
        SensorNoise(gyro=np.nan)
    with pytest.raises(PlantError, match="not negative"):
        SensorNoise().scaled(-1.0)


def test_divergence_is_found_in_its_first_tick_and_names_the_fastest_joint():
    r = robot()
    v = np.zeros(r.nv)
    v[6 + 3] = 1e5
    with Mujoco(r, collisions="soles") as plant:
        plant.reset(State(r.standing().q, v))
        with pytest.raises(PhysicsDiverged, match=r"diverged at 0\.002 s: joint .* rad/s"):
            plant.step(command(np.zeros(r.na)))
