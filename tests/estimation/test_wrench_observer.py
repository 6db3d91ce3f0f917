"""Contact wrenches from joint torques and IMU."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest
from simtools import robot

import wbc
from wbc.errors import MeasurementError
from wbc.estimation import Estimator
from wbc.estimation.wrench_observer import WrenchObserver
from wbc.measurement import Measurement
from wbc.sim import Mujoco


def test_wrenches_that_hold_a_robot_at_rest_are_found_exactly() -> None:
    g1 = robot("g1")
    model, data = g1.model, g1.model.createData()
    q = g1.standing().q
    generator = np.random.default_rng(0)
    wanted = {g1.soles[1].name: generator.uniform(-5.0, 5.0, 6)}
    J = {}
    for sole in g1.soles:
        frame = g1.frame_id(sole.name)
        J[sole.name] = pin.computeFrameJacobian(model, data, q, frame, pin.ReferenceFrame.LOCAL)
    gravity = pin.computeGeneralizedGravity(model, data, q)
    first, second = (sole.name for sole in g1.soles)
    wanted[second][2] += 0.3 * g1.weight
    rest = gravity[:6] - J[second].T[:6] @ wanted[second]
    wanted[first] = np.linalg.solve(J[first].T[:6], rest)
    tau = gravity - sum(J[name].T @ wrench for name, wrench in wanted.items())
    still = np.zeros(g1.na)
    specific_force = np.array([0.0, 0.0, 9.81])
    m = Measurement(0.0, q[7:], still, np.zeros(3), specific_force, joint_torque=tau[6:])
    found = WrenchObserver(g1, 0.002).update(m, q[7:], still)
    for name, wrench in wanted.items():
        np.testing.assert_allclose(found[name], wrench, atol=1e-3)


def test_a_robot_without_foot_sensors_walks_on_what_its_joint_torques_say() -> None:
    g1 = robot("g1")
    plant = Mujoco(g1, foot_sensors=False)
    walker, estimator = wbc.Walker(g1), Estimator(g1)
    walker.velocity = (0.3, 0.0, 0.0)
    expected, right, ticks = None, 0, round(2.5 / plant.dt)
    for _ in range(ticks):
        m = plant.measure()
        assert not m.foot_wrenches
        estimate = estimator.update(m, acceleration=expected)
        assert estimate.loads is None  # the walker times its steps by its plan
        loaded = {name for name, f in plant.foot_forces.items() if f[2] > 0.07 * g1.weight}
        right += loaded == set(estimate.contacts)
        command = walker.step(estimate)
        expected = command.acceleration
        plant.step(command)
    assert right > 0.93 * ticks
    assert plant.ground_truth().q[0] > 0.25
    copies = [copy.deepcopy(estimator), pickle.loads(pickle.dumps(estimator))]
    m = plant.measure()
    after = estimator.update(m)
    for one in copies:
        again = one.update(m)
        np.testing.assert_array_equal(again.state.q, after.state.q)
        assert again.contacts == after.contacts


def test_a_torque_that_is_not_finite_is_refused() -> None:
    g1 = robot("g1")
    still = np.zeros(g1.na)
    m = Measurement(0.0, still, still, np.zeros(3), np.zeros(3), joint_torque=still + np.nan)
    with pytest.raises(MeasurementError, match="joint_torque"):
        Estimator(g1).update(m)
