"""The estimator against the truth of the physics."""

from __future__ import annotations

import dataclasses
import os
import pickle
import subprocess
import sys
from functools import cache

import numpy as np
import pinocchio as pin
import pytest
from simtools import JointPDController, SwayOffsets, moved, robot, roll_pitch_yaw, run

from wbc.errors import ContactError, MeasurementError, StateError
from wbc.estimation import ContactTrigger, Estimator, EstimatorNoise, GroundTruthEstimator
from wbc.gait import Phase
from wbc.measurement import Measurement
from wbc.sim import Mujoco, SensorNoise
from wbc.state import State
from wbc.trials.closed_loop import ClosedLoop
from wbc.walking import Walker

pytest.importorskip("mujoco")


@dataclasses.dataclass
class Trial:
    """A run of a swaying robot: measurements with the truth, and the plant's biases."""

    measurements: list[Measurement]
    gyro_bias: np.ndarray
    accelerometer_bias: np.ndarray


@cache
def swaying(name: str = "talos", duration: float = 6.0, quiet: bool = False, far: bool = False):
    r = robot(name)
    hold, sway = JointPDController(r), SwayOffsets(r)
    noise = SensorNoise.none() if quiet else SensorNoise()
    found = []
    with Mujoco(r, ground_truth=True, noise=noise, seed=3) as plant:
        if far:
            plant.reset(moved(r.standing(), (100.0, -50.0, 0.0), 2.0))
        for _ in range(round(duration / plant.dt)):
            m = plant.measure()
            found.append(m)
            plant.step(hold(m, sway(plant.time)))
        return Trial(found, plant._noise.gyro_bias, plant._noise.accelerometer_bias)


def follow(estimator: Estimator, trial: Trial) -> list[State]:
    estimator.reset(trial.measurements[0].ground_truth)
    blind = (dataclasses.replace(m, ground_truth=None) for m in trial.measurements)
    return [estimator.update(m).state for m in blind]


def errors(trial: Trial, states: list[State]) -> dict[str, np.ndarray]:
    pairs = list(zip(states, (m.ground_truth for m in trial.measurements), strict=True))
    return {
        "attitude": np.array([roll_pitch_yaw(s) - roll_pitch_yaw(t) for s, t in pairs]),
        "place": np.array([s.q[:3] - t.q[:3] for s, t in pairs]),
        "linear": np.array([s.v[:3] - t.v[:3] for s, t in pairs]),
        "angular": np.array([s.v[3:6] - t.v[3:6] for s, t in pairs]),
        "joints": np.array([s.v[6:] - t.v[6:] for s, t in pairs]),
    }


def rms(x: np.ndarray) -> np.ndarray:
    return np.sqrt(np.mean(x**2, axis=0))


@pytest.mark.parametrize("name", ["talos", "g1", "romeo", "simple_humanoid"])
def test_the_estimate_follows_a_swaying_robot(name):
    r = robot(name)
    trial = swaying(name)
    moving = max(np.abs(m.ground_truth.v[:3]).max() for m in trial.measurements)
    assert moving > 0.01, "the robot is to move"
    e = errors(trial, follow(Estimator(r), trial))
    settled = {key: value[500:] for key, value in e.items()}
    assert np.degrees(rms(settled["attitude"][:, :2])).max() < 0.2
    assert np.degrees(np.abs(settled["attitude"][:, 2])).max() < 0.5
    assert rms(settled["linear"]).max() < 0.01
    assert np.abs(settled["linear"].mean(axis=0)).max() < 0.005
    assert rms(settled["angular"]).max() < 0.04
    assert np.abs(settled["place"]).max() < 0.01
    assert rms(settled["joints"].ravel()) < (0.055 if name == "g1" else 0.04)


def test_without_noise_the_estimate_is_nearly_exact():
    r = robot()
    trial = swaying(quiet=True, duration=3.0)
    e = errors(trial, follow(Estimator(r, joint_acceleration=np.inf), trial))
    # What is left is the soles': they rock and creep a little under a swaying robot.
    assert np.degrees(np.abs(e["attitude"])).max() < 0.15
    assert rms(e["linear"]).max() < 2e-3
    assert np.abs(e["angular"]).max() < 2e-3
    assert np.abs(e["place"]).max() < 5e-3
    np.testing.assert_array_equal(e["joints"], 0.0)


def test_gyro_bias_is_estimated():
    r = robot()
    trial = swaying()
    estimator = Estimator(r)
    follow(estimator, trial)
    assert np.abs(trial.gyro_bias).max() > 5e-4, "there is a bias to find"
    np.testing.assert_allclose(estimator.filter.gyro_bias, trial.gyro_bias, atol=4e-4)


def test_large_gyro_bias_is_estimated_from_standing_soles():
    r = robot()
    trial = swaying()
    bias = np.array([0.01, -0.015, 0.02])
    biased = Trial(
        [dataclasses.replace(m, gyro=m.gyro + bias) for m in trial.measurements], bias, bias
    )
    estimator = Estimator(r)
    states = follow(estimator, biased)
    np.testing.assert_allclose(estimator.filter.gyro_bias, trial.gyro_bias + bias, atol=2.5e-3)
    e = errors(biased, states)
    assert np.degrees(np.abs(e["attitude"][1500:])).max() < 1.0


def test_vertical_accelerometer_bias_is_estimated():
    r = robot()
    trial = swaying()
    estimator = Estimator(r)
    follow(estimator, trial)
    data = r.model.createData()
    pin.framesForwardKinematics(r.model, data, trial.measurements[-1].ground_truth.q)
    up = data.oMf[r.frame_id(r.imu)].rotation[2]
    # The horizontal ones cannot be told from a tilt by a robot that stands.
    found = up @ (estimator.filter.accelerometer_bias - trial.accelerometer_bias)
    assert abs(found) < 2e-3
    assert abs(up @ trial.accelerometer_bias) > 4e-3, "there is a bias to find"


def test_a_wrong_first_tilt_is_corrected():
    r = robot()
    trial = swaying()
    start = trial.measurements[0].ground_truth
    tilted = start.q.copy()
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(0.02, -0.02, 0.0))
    tilted[3:7] = (turn * pin.Quaternion(start.q[3:7])).coeffs()
    estimator = Estimator(r)
    estimator.reset(State(tilted, start.v))
    states = [estimator.update(m).state for m in trial.measurements]
    e = errors(trial, states)["attitude"]
    assert np.degrees(np.abs(e[0, :2])).min() > 1.0
    assert np.degrees(np.abs(e[2000:, :2])).max() < 0.3


def test_slipping_sole_does_not_disturb_the_bias_estimate():
    r = robot()
    trial = swaying()
    turned = 0.0
    bent = []
    # Both legs turn the robot by 6 degrees within 0.2 s while the IMU does not feel it.
    yaw = [
        i for i, leg in enumerate(r.joint_names) if leg in ("leg_left_1_joint", "leg_right_1_joint")
    ]
    for m in trial.measurements[:2000]:
        if 2.0 < m.time < 2.2:
            turned += 0.1 / 100.0
        q = m.joint_position.copy()
        q[yaw] += turned
        bent.append(dataclasses.replace(m, joint_position=q))
    off = []
    for gate in (EstimatorNoise().slip_gate, np.inf):
        estimator = Estimator(r, noise=EstimatorNoise(slip_gate=gate))
        follow(estimator, Trial(bent, trial.gyro_bias, trial.accelerometer_bias))
        off.append(np.abs(estimator.filter.gyro_bias - trial.gyro_bias).max())
    assert off[0] < 0.005
    assert off[1] > 0.015


def test_estimation_errors_agree_with_the_filters_covariance():
    r = robot()
    trial = swaying()
    estimator = Estimator(r)
    follow(estimator, trial)
    sigma = np.sqrt(np.diag(estimator.filter.P))
    assert np.all(np.linalg.eigvalsh(estimator.filter.P) > -1e-12)
    np.testing.assert_allclose(estimator.filter.P, estimator.filter.P.T, atol=1e-9)
    off = np.abs(estimator.filter.gyro_bias - trial.gyro_bias)
    assert np.all(off < 4.0 * sigma[-6:-3])
    assert sigma[3:6].max() < 0.02


def test_estimate_is_equivariant_to_position_and_heading():
    r = robot()
    trial = swaying(duration=2.0)
    away = Trial(
        [
            dataclasses.replace(m, ground_truth=moved(m.ground_truth, (100.0, -50.0, 0.0), 2.0))
            for m in trial.measurements
        ],
        trial.gyro_bias,
        trial.accelerometer_bias,
    )
    here, there = follow(Estimator(r), trial), follow(Estimator(r), away)
    for a, b in zip(here[::50], there[::50], strict=True):
        expected = moved(a, (100.0, -50.0, 0.0), 2.0)
        np.testing.assert_allclose(b.v, expected.v, atol=1e-8)
        np.testing.assert_allclose(b.q[:3], expected.q[:3], atol=1e-8)
        np.testing.assert_allclose(roll_pitch_yaw(b), roll_pitch_yaw(expected), atol=1e-8)


def test_estimate_follows_a_robot_far_from_the_origin_and_turned():
    trial = swaying(far=True, duration=3.0)
    e = errors(trial, follow(Estimator(robot()), trial))
    assert np.abs(e["place"]).max() < 0.01
    assert rms(e["linear"][500:]).max() < 0.01


@pytest.mark.parametrize("hint", [None, ("left_sole", "right_sole")])
def test_without_foot_sensors_contacts_come_from_kinematics_or_the_caller(hint):
    r = robot()
    trial = swaying(duration=3.0)
    estimator = Estimator(r)
    estimator.reset(trial.measurements[0].ground_truth)
    bare = [dataclasses.replace(m, foot_wrenches={}) for m in trial.measurements]
    states = [estimator.update(m, contacts=hint).state for m in bare]
    assert estimator.contacts == ("left_sole", "right_sole")
    assert rms(errors(trial, states)["linear"][500:]).max() < 0.01


def test_contacts_switch_with_hysteresis():
    r = robot()
    estimator = Estimator(r)
    m = swaying(duration=3.0).measurements[0]
    weight = 9.81 * r.mass
    seen = []
    for share in (0.5, 0.08, 0.06, 0.04, 0.06, 0.08, 0.12):
        feet = {"left_sole": np.zeros(6), "right_sole": np.zeros(6)}
        feet["left_sole"][2] = share * weight
        feet["right_sole"][2] = 0.5 * weight
        estimator.update(dataclasses.replace(m, foot_wrenches=feet))
        assert "right_sole" in estimator.contacts
        seen.append("left_sole" in estimator.contacts)
    assert seen == [True, True, True, False, False, False, True]


def test_free_fall_is_integrated_from_the_imu():
    r = robot()
    start = moved(r.standing(), (0.0, 0.0, 1.0), 0.0)
    with Mujoco(r, noise=SensorNoise.none(), ground_truth=True) as plant:
        plant.reset(start)
        estimator = Estimator(r)
        estimator.reset(start)
        hold = JointPDController(r)
        for _ in range(100):
            state = estimator.update(plant.measure()).state
            plant.step(hold(plant.measure()))
        assert estimator.contacts == ()
        truth = plant.measure().ground_truth
        state = estimator.update(plant.measure()).state
    assert truth.v[2] < -1.5
    np.testing.assert_allclose(state.q[:3], truth.q[:3], atol=5e-3)
    np.testing.assert_allclose(state.v[:3], truth.v[:3], atol=0.02)


def test_estimator_never_reads_the_ground_truth():
    r = robot()
    trial = swaying(duration=2.0)
    lied = [
        dataclasses.replace(m, ground_truth=State(np.full(r.nq, np.nan), np.full(r.nv, np.nan)))
        for m in trial.measurements
    ]
    estimator = Estimator(r)
    estimator.reset(trial.measurements[0].ground_truth)
    last = [estimator.update(m) for m in lied][-1].state
    np.testing.assert_array_equal(last.q, follow(Estimator(r), trial)[-1].q)


def test_ground_truth_estimator_returns_the_true_state_or_an_error():
    r = robot()
    with Mujoco(r, ground_truth=True) as plant:
        run(plant, 0.02, JointPDController(r))
        m = plant.measure()
    estimator = GroundTruthEstimator(r)
    estimator.reset(r.standing())
    estimate = estimator.update(m)
    assert estimate.state is m.ground_truth
    assert estimate.contacts == ("left_sole", "right_sole")
    assert sum(estimate.loads.values()) == pytest.approx(1.0, abs=0.1)
    with pytest.raises(MeasurementError, match="ground_truth=True"):
        estimator.update(dataclasses.replace(m, ground_truth=None))


def _with(array: np.ndarray, index: int, value: float) -> np.ndarray:
    changed = array.copy()
    changed[index] = value
    return changed


@pytest.mark.parametrize("field", ["joint_position", "joint_velocity", "gyro", "accelerometer"])
def test_invalid_readings_are_refused_by_name(field):
    estimator = Estimator(robot())
    m = swaying(duration=2.0).measurements[0]
    reading = getattr(m, field)
    with pytest.raises(MeasurementError, match=f"{field} has shape"):
        estimator.update(dataclasses.replace(m, **{field: reading[:-1]}))
    with pytest.raises(MeasurementError, match=rf"{field}\[1\] is nan"):
        estimator.update(dataclasses.replace(m, **{field: _with(reading, 1, np.nan)}))
    with pytest.raises(MeasurementError, match=f"{field} is None|{field} is missing"):
        estimator.update(dataclasses.replace(m, **{field: None}))
    assert not estimator.contacts, "a reading that is refused changes nothing"


def test_read_only_and_strided_arrays_are_taken():
    m = swaying(duration=2.0).measurements[0]
    acceleration = np.repeat(np.linspace(-1.0, 1.0, robot().nv), 2)[::2]
    other = dataclasses.replace(m, joint_position=m.joint_position.copy())
    given = [acceleration.copy(), acceleration, acceleration.copy()]
    for array in (given[2], other.joint_position):
        array.setflags(write=False)
    states = []
    for array, reading in zip(given, (m, m, other), strict=True):
        estimator = Estimator(robot())
        estimator.update(m)  # the first reading is taken as it is, whatever is foreseen
        states.append(estimator.update(reading, acceleration=array).state)
    for state in states[1:]:
        np.testing.assert_array_equal(state.v, states[0].v)


def test_readings_of_other_number_types_are_taken():
    m = swaying(duration=2.0).measurements[0]
    q = m.joint_position.astype(np.float32)
    other = dataclasses.replace(m, joint_position=q, gyro=np.zeros(3, int))
    same = dataclasses.replace(m, joint_position=q.astype(float), gyro=np.zeros(3))
    states = [Estimator(robot()).update(reading).state for reading in (other, same)]
    np.testing.assert_array_equal(states[0].q, states[1].q)


@pytest.mark.parametrize(
    "bad", [np.zeros(7), np.full(38, np.nan), 0.0, np.zeros((38, 1)), [0.0] * 38]
)
def test_a_foreseen_acceleration_that_makes_no_sense_is_refused(bad):
    m = swaying(duration=2.0).measurements[0]
    with pytest.raises(MeasurementError, match="acceleration is"):
        Estimator(robot()).update(m, acceleration=bad)


def test_invalid_foot_wrenches_and_contacts_are_refused_by_name():
    estimator = Estimator(robot())
    m = swaying(duration=2.0).measurements[0]
    for wrench in (None, np.zeros(3), np.full(6, np.nan)):
        feet = {"left_sole": np.zeros(6)}
        if wrench is not None:
            feet["right_sole"] = wrench
        with pytest.raises(MeasurementError, match="right_sole"):
            estimator.update(dataclasses.replace(m, foot_wrenches=feet))
    with pytest.raises(ContactError, match="middle_sole"):
        estimator.update(m, contacts=("middle_sole",))


@pytest.mark.parametrize("bad", [[0.0] * 6, np.zeros((1, 6)), np.array(["0"] * 6), 0.0])
def test_a_foot_wrench_that_is_no_array_of_six_numbers_is_refused(bad):
    m = swaying(duration=2.0).measurements[0]
    feet = {"left_sole": np.zeros(6), "right_sole": bad}
    with pytest.raises(MeasurementError, match=r"right_sole.*six finite numbers"):
        Estimator(robot()).update(dataclasses.replace(m, foot_wrenches=feet))


def test_foot_wrenches_of_other_numbers_than_floats_are_taken():
    measurements, estimates = swaying(duration=2.0).measurements[:40], []
    for convert in (np.copy, lambda w: w.astype(int), read_only):
        estimator = Estimator(robot())
        for m in measurements:
            feet = {name: convert(np.round(w)) for name, w in m.foot_wrenches.items()}
            estimate = estimator.update(dataclasses.replace(m, foot_wrenches=feet))
        estimates.append(estimate)
    for other in estimates[1:]:
        np.testing.assert_array_equal(other.state.q, estimates[0].state.q)
        assert other.loads == estimates[0].loads


def read_only(wrench):
    wrench.flags.writeable = False
    return wrench


def test_an_invalid_initial_state_is_refused():
    r = robot()
    with pytest.raises(StateError):
        Estimator(r).reset(State(np.zeros(3), np.zeros(r.nv)))


def test_returned_state_is_not_changed_by_later_updates():
    estimator = Estimator(robot())
    trial = swaying(duration=2.0)
    first = estimator.update(trial.measurements[0]).state
    kept = first.q.copy(), first.v.copy()
    for m in trial.measurements[1:10]:
        second = estimator.update(m).state
    np.testing.assert_array_equal(first.q, kept[0])
    np.testing.assert_array_equal(first.v, kept[1])
    assert np.linalg.norm(second.q[3:7]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("yaw", [0.0, 3.0, -3.0])
def test_estimated_quaternion_has_positive_w(yaw):
    r = robot()
    start = moved(r.standing(), (1.0, 2.0, 0.0), yaw)
    estimator = Estimator(r)
    estimator.reset(start)
    still = np.zeros(r.na), np.zeros(3), np.array([0.0, 0.0, 9.81])
    state = estimator.update(Measurement(0.0, start.q[7:], *still)).state
    expected = start.q[3:7] if start.q[6] >= 0.0 else -start.q[3:7]
    np.testing.assert_allclose(state.q[3:7], expected, atol=1e-9)


@pytest.mark.parametrize("dt", [0.0, -0.002, np.nan, np.inf])
def test_invalid_control_period_is_refused(dt):
    with pytest.raises(MeasurementError, match="dt = "):
        Estimator(robot(), dt)


def test_invalid_deviations_and_thresholds_are_refused():
    with pytest.raises(MeasurementError, match="gyro = -1"):
        EstimatorNoise(gyro=-1.0)
    with pytest.raises(MeasurementError, match="correct_every = 0"):
        Estimator(robot(), correct_every=0)
    with pytest.raises(ContactError, match=r"on = 0\.1 and off = 0\.2"):
        ContactTrigger(on=0.1, off=0.2)


def test_repr_of_measurement_and_estimate_states_values_with_units():
    r = robot()
    m = swaying(duration=2.0).measurements[5]
    assert "32 joints" in repr(m)
    estimator = Estimator(r)
    text = repr(estimator.update(m))
    assert "contacts: left_sole, right_sole" in text
    assert "%" in text
    assert "talos" in repr(estimator)


WITHOUT_NUMBA = """
import sys
sys.modules["numba"] = None
"""
WITH_A_BROKEN_NUMBA = """
import numba
def njit(*args, **kwargs):
    raise RuntimeError("no such target")
numba.njit = njit
"""
ESTIMATE = """
import pickle, sys
import numpy as np
import wbc
measurements = pickle.load(sys.stdin.buffer)
estimator = wbc.Estimator(wbc.load("talos"))
estimator.reset(measurements[0].ground_truth)
states = [estimator.update(m).state for m in measurements]
pickle.dump(np.array([np.concatenate([s.q, s.v]) for s in states]), sys.stdout.buffer)
"""


@pytest.mark.parametrize("numba", [WITHOUT_NUMBA, WITH_A_BROKEN_NUMBA])
def test_estimate_is_the_same_without_a_working_numba(numba):
    measurements = swaying(duration=2.0).measurements[:60]
    done = subprocess.run(
        [sys.executable, "-c", numba + ESTIMATE],
        input=pickle.dumps(measurements),
        capture_output=True,
        check=True,
        env={**os.environ, "PYTHONPATH": ":".join(sys.path)},
    )
    estimator = Estimator(robot())
    estimator.reset(measurements[0].ground_truth)
    states = [estimator.update(m).state for m in measurements]
    expected = np.array([np.concatenate([s.q, s.v]) for s in states])
    np.testing.assert_allclose(pickle.loads(done.stdout), expected, atol=1e-12)


@pytest.mark.parametrize(("jump", "found"), [(EstimatorNoise().jump, True), (np.inf, False)])
def test_shock_that_the_accelerometer_does_not_tell_is_found_by_the_legs(jump: float, found: bool):
    r = robot("g1")
    hold = JointPDController(r)
    estimator = Estimator(r, noise=EstimatorNoise(jump=jump))
    with Mujoco(r, ground_truth=True, seed=1) as plant:
        estimator.reset(plant.ground_truth())
        off = []
        for period in range(230):
            if period == 200:
                plant.kick((0.8, 0.0, 0.0))
            m = plant.measure()
            off.append(abs(estimator.update(m).state.v[0] - m.ground_truth.v[0]))
            plant.step(hold(m))
    assert off[200] > 0.7
    assert (max(off[210:]) < 0.15) == found


def test_a_kick_in_a_step_is_found_whenever_it_comes_between_two_corrections():
    """One that comes right before a correction has moved the sole by a fraction only by then."""
    r = robot("g1")
    walker = Walker(r)
    walker.velocity = (0.3, 0.0, 0.0)
    loop = ClosedLoop(r, Mujoco(r, ground_truth=True, seed=2), Estimator(r), walker)
    loop.reset()
    state = walker.gait_state
    while not (state.steps == 2 and state.phase is Phase.SWING and state.time > 0.1):
        loop.tick()
    saved = pickle.dumps(loop)
    for later in range(4):
        loop = pickle.loads(saved)
        for _ in range(later):
            loop.tick()
        away = -1.0 if state.support == "left" else 1.0  # from the foot that stands
        loop.plant.kick((0.0, away, 0.0))
        for _ in range(20):
            estimate, _ = loop.tick()
        off = estimate.state.v[1] - loop.plant.measure().ground_truth.v[1]
        assert abs(off) < 0.35, f"kicked {later} ticks later"
