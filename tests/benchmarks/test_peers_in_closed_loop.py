"""Other libraries in closed loop: what passes between the processes."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import wbc

BENCHMARKS = Path(__file__).parents[2] / "benchmarks"
sys.path.insert(0, str(BENCHMARKS))

from peers import placo_walking  # noqa: E402
from peers.closed_loop import save_case  # noqa: E402
from peers.reference import Reference  # noqa: E402

from wbc.errors import GaitError  # noqa: E402

# An adapter whose torques are the joint positions and whose accelerations are the velocities.
ECHO = """
import sys, types
class Echo:
    def __init__(self, case): self.case = case
    def follow(self, reference): self.reference = reference
    def solve(self): return True, self.reference.q[7:], self.reference.v
sys.modules["peers.adapters.echo"] = types.SimpleNamespace(Echo=Echo)
from peers.stream_worker import main
main()
"""


def random_reference(nv: int, seed: int) -> Reference:
    rng = np.random.default_rng(seed)
    packed = rng.standard_normal(Reference.size(nv))
    packed[:3] = 2, 1, 350.0
    return Reference.unpack(packed, nv)


def test_a_packed_reference_is_unpacked_as_it_was():
    reference = random_reference(12, 0)
    again = Reference.unpack(reference.pack(), 12)
    assert (again.stance, again.leaving, again.max_force) == (2, 1, 350.0)
    assert (again.torso.shape, again.swing.shape) == ((3, 3), (4, 4))
    np.testing.assert_array_equal(again.pack(), reference.pack())


def test_a_worker_replies_to_each_tick_until_its_input_ends(tmp_path):
    robot = wbc.load("simple_humanoid")
    save_case(robot, tmp_path)
    references = [random_reference(robot.nv, seed) for seed in range(3)]
    done = subprocess.run(
        [sys.executable, "-c", ECHO, "echo:Echo", str(tmp_path)],
        input=b"".join(reference.pack().tobytes() for reference in references),
        capture_output=True,
        env=os.environ | {"PYTHONPATH": str(BENCHMARKS)},
    )
    assert done.returncode == 0, done.stderr
    replies = np.frombuffer(done.stdout).reshape(-1, 1 + robot.na + robot.nv)
    assert not replies[0].any()  # ready
    for reply, reference in zip(replies[1:], references, strict=True):
        np.testing.assert_array_equal(reply, [1.0, *reference.q[7:], *reference.v])


def test_the_case_of_a_robot_has_a_tick_for_each_set_of_standing_feet(tmp_path):
    from peers.case import BOTH, LEFT, RIGHT, Case

    robot = wbc.load("simple_humanoid")
    save_case(robot, tmp_path)
    case = Case.load(tmp_path)
    assert case.ticks.stance.tolist() == [BOTH, LEFT, RIGHT]
    assert case.joints == robot.joint_names
    assert case.limits.torque == pytest.approx(robot.tau_max)


def test_placos_walk_goes_forward_and_a_copy_of_it_goes_on_alike(monkeypatch):
    pytest.importorskip("mujoco")
    monkeypatch.setattr(placo_walking, "DURATION", 3.0)
    robot = wbc.load("talos")
    controller = placo_walking.PlacoController(robot, 0.002)
    controller.velocity = (0.2, 0.0, 0.0)
    with pytest.raises(GaitError, match="straight ahead only"):
        controller.velocity = (0.2, 0.1, 0.0)
    plant, estimator = wbc.sim.Mujoco(robot), wbc.Estimator(robot)
    estimator.reset(robot.standing())

    def run(plant, estimator, controller, ticks):
        for _ in range(ticks):
            plant.step(controller.step(estimator.update(plant.measure())))
        return plant.ground_truth().q

    run(plant, estimator, controller, 1600)
    twin = pickle.loads(pickle.dumps((plant, estimator, controller)))
    end = run(plant, estimator, controller, 400)
    np.testing.assert_array_equal(end, run(*twin, 400))
    assert 0.1 < end[0] < 0.8
    assert end[2] > 0.9 * robot.q_nominal[2]
