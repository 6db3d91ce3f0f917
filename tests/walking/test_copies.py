"""Plant, estimator and walker saved at any tick go on as the originals do, bit by bit."""

from __future__ import annotations

import copy
import pickle
import subprocess
import sys
from dataclasses import dataclass

import numpy as np
import pytest

import wbc
from wbc.sim import Mujoco

pytest.importorskip("mujoco")

TICKS = 150  # 0.3 s


@dataclass
class Loop:
    """All that a closed loop carries from tick to tick."""

    plant: Mujoco
    estimator: wbc.Estimator
    walker: wbc.Walker
    expected: np.ndarray | None = None

    def run(self, ticks: int) -> np.ndarray:
        """(ticks, na) torques."""
        torques = []
        for _ in range(ticks):
            estimate = self.estimator.update(self.plant.measure(), acceleration=self.expected)
            command = self.walker.step(estimate)
            self.expected = command.acceleration
            self.plant.step(command)
            torques.append(command.tau)
        return np.array(torques)


def walking(name: str) -> Loop:
    robot = wbc.load(name)
    loop = Loop(Mujoco(robot, seed=1, latency=0.001), wbc.Estimator(robot), wbc.Walker(robot))
    start = loop.plant.ground_truth()
    loop.estimator.reset(start)
    loop.walker.reset(start)
    loop.walker.velocity = (0.25, 0.03, 0.1)
    loop.plant.schedule_push(0.9, [0.1 * robot.mass, 0.05 * robot.mass, 0.0])
    return loop


#: In another process: run each pickled loop on and send its torques back.
GO_ON = f"""
import pickle, sys
loops = [pickle.loads(data) for data in pickle.load(sys.stdin.buffer)]
pickle.dump([loop.run({TICKS}) for loop in loops], sys.stdout.buffer)
"""


@pytest.mark.parametrize("name", ["talos", "g1"])
def test_copies_of_a_walk_continue_bit_identically_here_and_in_another_process(name):
    loop = walking(name)
    ticks = np.sort(np.random.default_rng(3).choice(650, 5, replace=False)).tolist()
    torques, pickled = np.empty((0, loop.walker.robot.na)), []
    copies = []
    for tick in ticks:
        torques = np.vstack((torques, loop.run(tick - len(torques))))
        copies.append(copy.deepcopy(loop))
        pickled.append(pickle.dumps(loop))
    torques = np.vstack((torques, loop.run(ticks[-1] + TICKS - len(torques))))
    assert loop.walker.steps >= 1
    expected = [torques[tick : tick + TICKS] for tick in ticks]
    for tick, other, original in zip(ticks, copies, expected, strict=True):
        np.testing.assert_array_equal(other.run(TICKS), original, err_msg=f"copied at {tick}")
    done = subprocess.run(
        [sys.executable, "-c", GO_ON],
        input=pickle.dumps(pickled),
        capture_output=True,
        check=True,
        env={"PYTHONPATH": ":".join(sys.path)},
    )
    for tick, other, original in zip(ticks, pickle.loads(done.stdout), expected, strict=True):
        np.testing.assert_array_equal(other, original, err_msg=f"pickled at {tick}")


def test_pickled_loop_is_small():
    loop = walking("talos")
    loop.run(5)
    robot = len(pickle.dumps(loop.walker.robot))
    assert len(pickle.dumps(loop)) < robot + 1_200_000
    assert len(pickle.dumps(loop.estimator)) < robot + 60_000


def test_a_copied_loop_does_not_touch_the_original():
    loop = walking("talos")
    loop.run(20)
    one, other = copy.deepcopy(loop), copy.deepcopy(loop)
    one.walker.velocity = (-0.1, 0.0, 0.0)
    one.plant.push([20.0, 0.0, 0.0])
    one.run(60)
    np.testing.assert_array_equal(loop.run(60), other.run(60))
