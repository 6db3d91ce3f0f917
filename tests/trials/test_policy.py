"""Learned policies: what the network reads, what is made of its output, and wrong files."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pinocchio as pin
import pytest
from policytools import linear_network, load_network, write_standing_policy

import wbc
from wbc.errors import JointNotFound
from wbc.estimation import Estimate
from wbc.robot.fall import fall_reason
from wbc.runtime.protocols import VelocityController
from wbc.trials import ControllerSpec, TrialError
from wbc.trials.policy import PolicyController, PolicyDescription, PolicyError, load_policy

pytest.importorskip("yaml")

TERMS = {
    "base_ang_vel": "{scale: [0.2, 0.2, 0.2], clip: null, history_length: 2, params: {}}",
    "projected_gravity": "{scale: 1.0, clip: null, history_length: 1}",
    "velocity_commands": "{scale: [1, 2, 3], clip: null, history_length: 1}",
    "joint_pos_rel": "{scale: 1.0, clip: null, history_length: 3}",
    "joint_vel_rel": "{scale: 0.05, clip: [-1.0, 1.0], history_length: 1}",
    "last_action": "{scale: 1.0, clip: null, history_length: 1}",
}


@pytest.fixture(scope="module")
def robot():
    return wbc.load("simple_humanoid")


def description_text(robot, **changes: str) -> str:
    """A description whose network has the robot's joints in reversed order."""
    n = robot.na
    keys = {
        "step_dt": "0.02",
        "joint_ids_map": str(list(range(n))[::-1]),
        "stiffness": str([100.0 + i for i in range(n)]),
        "damping": str([1.0 + 0.1 * i for i in range(n)]),
        "default_joint_pos": str((0.01 * np.arange(n)).tolist()),
        "commands": "{base_velocity: {ranges: {lin_vel_x: [-0.5, 1.0], lin_vel_y: [-0.3, 0.3], "
        "ang_vel_z: [-0.2, 0.2], heading: null}}}",
        "actions": "{JointPositionAction: {scale: 0.25, offset: 0.1, clip: null, "
        "joint_ids: !!python/object/apply:builtins.slice [null, null, null]}}",
        "observations": "{" + ", ".join(f"{k}: {v}" for k, v in TERMS.items()) + "}",
    }
    return "\n".join(f"{key}: {value}" for key, value in (keys | changes).items())


def describe(robot, **changes: str) -> PolicyDescription:
    return PolicyDescription.parse(description_text(robot, **changes))


def input_size(robot) -> int:
    return 2 * 3 + 3 + 3 + 3 * robot.na + robot.na + robot.na


def reading_network(robot, first: int):
    """A network whose output is the part of its input that begins at an entry."""
    weights = np.zeros((input_size(robot), robot.na))
    weights[first : first + robot.na] = np.eye(robot.na)
    return load_network(weights)


def random_estimate(robot, seed: int) -> Estimate:
    rng = np.random.default_rng(seed)
    q = pin.integrate(robot.model, robot.q_nominal, 0.2 * rng.standard_normal(robot.nv))
    return Estimate(wbc.State(q, 0.5 * rng.standard_normal(robot.nv)))


def test_the_input_is_term_after_term_each_from_the_oldest_value_to_the_newest(robot):
    seen = []
    network = load_network(np.zeros((input_size(robot), robot.na)), np.full(robot.na, 0.5))

    class Spy:
        inputs, outputs = network.inputs, network.outputs

        def __call__(self, observation):
            seen.append(observation.copy())
            return network(observation)

    policy = PolicyController(robot, describe(robot), Spy(), dt=0.02)
    policy.velocity = (0.5, 0.1, -0.1)
    estimates = [random_estimate(robot, seed) for seed in range(3)]
    for estimate in estimates:
        policy.step(estimate)

    def joints(estimate):
        return estimate.state.q[7:][::-1] - 0.01 * np.arange(robot.na)

    old, new = estimates[-2].state, estimates[-1].state
    gravity = pin.Quaternion(new.q[3:7]).toRotationMatrix().T @ np.array([0.0, 0.0, -1.0])
    expected = [
        0.2 * old.v[3:6],
        0.2 * new.v[3:6],
        gravity,
        [0.5, 0.2, -0.3],
        *(joints(estimate) for estimate in estimates),
        0.05 * np.clip(new.v[6:][::-1], -1.0, 1.0),
        np.full(robot.na, 0.5),
    ]
    np.testing.assert_allclose(seen[-1], np.concatenate(expected), atol=1e-6)
    # At the first evaluation the present value fills the history, and there was no action.
    first = seen[0]
    np.testing.assert_allclose(first[:3], first[3:6])
    np.testing.assert_allclose(first[12 : 12 + robot.na], joints(estimates[0]), atol=1e-6)
    assert not first[-robot.na :].any()


def test_torques_are_a_pd_law_on_scaled_actions_in_the_robots_order_and_within_its_limits(robot):
    rng = np.random.default_rng(1)
    action = 0.3 * rng.standard_normal(robot.na)
    network = load_network(np.zeros((input_size(robot), robot.na)), action)
    policy = PolicyController(robot, describe(robot), network)
    state = random_estimate(robot, 2).state
    command = policy.step(Estimate(state))
    kp, kd = 100.0 + np.arange(robot.na), 1.0 + 0.1 * np.arange(robot.na)
    target = 0.1 + 0.25 * action.astype(np.float32)[::-1]
    tau = kp * (target - state.q[7:]) - kd * state.v[6:]
    expected = np.clip(tau, -robot.tau_max, robot.tau_max)
    np.testing.assert_allclose(command.tau, expected, rtol=1e-5, atol=1e-5)
    assert (np.abs(tau) > robot.tau_max).any()


def test_clipped_actions_stay_within_the_joint_targets_that_the_description_allows(robot):
    changes = {"actions": "{JointPositionAction: {scale: 1.0, offset: 0.0, clip: [-0.2, 0.2]}}"}
    network = load_network(np.zeros((input_size(robot), robot.na)), np.full(robot.na, 5.0))
    policy = PolicyController(robot, describe(robot, **changes), network)
    state = robot.standing()
    still = wbc.State(np.concatenate([state.q[:7], np.full(robot.na, 0.2)]), state.v)
    assert np.abs(policy.step(Estimate(still)).tau).max() < 1e-9


def test_the_network_is_evaluated_once_per_period_of_the_policy(robot):
    first = 2 * 3 + 3 + 3 + 2 * robot.na  # newest joint positions
    policy = PolicyController(robot, describe(robot), reading_network(robot, first), dt=0.005)
    held = random_estimate(robot, 3)
    torques = [policy.step(held).tau]
    other = wbc.State(random_estimate(robot, 4).state.q, held.state.v)
    policy.step(Estimate(other))
    torques += [policy.step(held).tau for _ in range(2)]
    np.testing.assert_array_equal(torques[0], torques[1])
    np.testing.assert_array_equal(torques[0], torques[2])
    policy.step(Estimate(other))  # the fifth tick: a new evaluation
    assert np.abs(policy.step(held).tau - torques[0]).max() > 1e-3


@pytest.mark.parametrize("clone", [copy.deepcopy, lambda p: pickle.loads(pickle.dumps(p))])
def test_a_copy_goes_on_bit_identically_and_apart(robot, clone):
    rng = np.random.default_rng(5)
    network = load_network(0.05 * rng.standard_normal((input_size(robot), robot.na)))
    policy = PolicyController(robot, describe(robot), network)
    for seed in range(13):
        policy.step(random_estimate(robot, seed))
    twin = clone(policy)
    later = [random_estimate(robot, seed) for seed in range(20, 45)]
    ours = [policy.step(estimate).tau for estimate in later]
    np.testing.assert_array_equal(ours, [twin.step(estimate).tau for estimate in later])
    twin.reset(robot.standing())
    assert (policy.step(later[0]).tau != twin.step(later[0]).tau).any()


def test_a_policy_that_asks_for_the_standing_posture_holds_g1_for_a_second(tmp_path):
    pytest.importorskip("mujoco")
    g1 = wbc.load("g1")
    write_standing_policy(tmp_path, g1)
    policy = load_policy(g1, folder=tmp_path)
    with wbc.sim.Mujoco(g1) as plant:
        report = wbc.run(policy, plant, 1.0)
        assert report.survived
        assert not fall_reason(g1, plant.ground_truth())
        assert np.abs(plant.ground_truth().q[7:] - g1.q_nominal[7:]).max() < 0.1


def test_an_output_that_is_not_finite_gives_a_damping_command_that_says_so(robot):
    network = load_network(np.zeros((input_size(robot), robot.na)), np.full(robot.na, np.nan))
    policy = PolicyController(robot, describe(robot), network)
    command = policy.step(random_estimate(robot, 6))
    assert command.status is wbc.Status.FAILED
    assert "not finite" in command.explanation
    assert np.isfinite(command.tau).all()


def test_a_velocity_beyond_what_the_policy_was_trained_for_is_clamped_with_a_warning(robot):
    network = load_network(np.zeros((input_size(robot), robot.na)))
    policy = PolicyController(robot, describe(robot), network)
    with pytest.warns(wbc.VelocityClamped, match="clamped to"):
        policy.velocity = (2.0, 0.1, -0.5)
    assert policy.velocity == (1.0, 0.1, -0.2)


def test_files_that_contradict_each_other_or_the_robot_are_refused(robot, tmp_path):
    text = description_text(robot)
    size, joints = input_size(robot), robot.na
    with pytest.raises(PolicyError, match=f"{size} inputs and {joints} outputs"):
        PolicyController(robot, describe(robot), load_network(np.zeros((size - 1, joints))))
    network = load_network(np.zeros((size, joints)))
    with pytest.raises(PolicyError, match="made for another robot"):
        PolicyController(wbc.load("g1"), PolicyDescription.parse(text), network)
    names = [*robot.joint_names[:-1], "tail"]
    with pytest.raises(JointNotFound, match="tail"):
        PolicyController(robot, describe(robot, joint_names=str(names)), network)
    with pytest.raises(PolicyError, match="no multiple"):
        PolicyController(robot, describe(robot, step_dt="0.003"), network)
    with pytest.raises(PolicyError, match=r"has no deploy.yaml"):
        load_policy(robot, folder=tmp_path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"stiffness": "[1.0, 2.0]"}, r"'stiffness' has shape \(2,\)"),
        ({"step_dt": "0.0"}, "'step_dt' is 0.0; it must be a positive time"),
        ({"joint_ids_map": "[0, 0, 1]"}, "each exactly once"),
        ({"damping": "null"}, "lacks the key 'damping'"),
        ({"actions": "{JointVelocityAction: {}}"}, "JointPositionAction and nothing else"),
        ({"observations": "{base_ang_veloc: {scale: 1.0}}"}, "did you mean 'base_ang_vel'"),
        ({"observations": "{last_action: {scale: [1.0, 2.0]}}"}, "one number, or"),
        ({"observations": "{gait_phase: {scale: 1.0}}"}, "it must be positive"),
    ],
)
def test_a_wrong_description_is_refused_with_file_and_key(robot, changes, message):
    with pytest.raises(PolicyError, match=message) as raised:
        PolicyDescription.parse(description_text(robot, **changes), "deploy.yaml")
    assert "deploy.yaml" in str(raised.value)


def test_a_file_that_is_no_network_is_refused(tmp_path, robot):
    pytest.importorskip("onnxruntime")
    (tmp_path / "deploy.yaml").write_text(description_text(robot))
    (tmp_path / "policy.onnx").write_bytes(b"not a network")
    with pytest.raises(PolicyError, match="no ONNX network that can be run"):
        load_policy(robot, folder=tmp_path)


def test_a_policy_is_a_controller_of_a_grid(robot, tmp_path):
    pytest.importorskip("onnxruntime")
    (tmp_path / "deploy.yaml").write_text(description_text(robot))
    network = linear_network(np.zeros((input_size(robot), robot.na)))
    (tmp_path / "policy.onnx").write_bytes(network)
    made = ControllerSpec("policy", "policy", {"folder": str(tmp_path)}).resolve()(robot, 0.002)
    assert isinstance(made, PolicyController)
    assert isinstance(made, VelocityController)
    with pytest.raises(TrialError, match="without a folder"):
        ControllerSpec("policy", "policy").resolve()
