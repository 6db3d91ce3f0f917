"""A controller that was copied or pickled goes on exactly as the one that it was made from."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest
from coretools import controller, robot, standing_state

import wbc

COPIES = {"copy": copy.deepcopy, "pickle": lambda thing: pickle.loads(pickle.dumps(thing))}
TICKS = range(6)


def drive(control: wbc.WholeBodyController, ticks: range) -> list[wbc.Command]:
    """Commands of a sequence that changes its target and its contacts."""
    commands = []
    both = control.contacts
    for k in ticks:
        control.tasks[0].acceleration[:] = (0.3 * k, -0.1, 0.2)
        control.set_contacts(both[:1] if k % 3 == 2 else both)
        commands.append(control.step(standing_state(control.robot, 40 + k, speed=0.2)))
        control.set_contacts(both)
    return commands


def assert_identical(ours: list[wbc.Command], theirs: list[wbc.Command]) -> None:
    for a, b in zip(ours, theirs, strict=True):
        assert a.status is b.status
        np.testing.assert_array_equal(a.tau, b.tau)
        np.testing.assert_array_equal(a.acceleration, b.acceleration)
        for name, wrench in a.wrenches.items():
            np.testing.assert_array_equal(wrench, b.wrenches[name])


@pytest.mark.parametrize("copied", COPIES.values(), ids=COPIES)
@pytest.mark.parametrize("formulation", list(wbc.Formulation))
def test_a_copied_controller_continues_bit_identically_and_shares_nothing(copied, formulation):
    control = controller(robot("talos"), "both", solver="wbc", formulation=formulation)
    drive(control, range(3))
    other = copied(control)
    assert_identical(drive(control, TICKS), drive(other, TICKS))
    other.tasks[0].weight = 1.0
    other.contacts[0].friction = 0.1
    assert control.tasks[0].weight[0] != 1.0
    assert control.contacts[0].friction != 0.1


def test_the_copy_of_a_controller_shares_its_robot():
    control = controller(robot("talos"), "both", solver="wbc", formulation=wbc.Formulation.COMPILED)
    assert copy.deepcopy(control).robot is control.robot


@pytest.mark.parametrize("solver", ["daqp", "osqp", "piqp"])
def test_a_copied_controller_with_another_solver_agrees_within_its_tolerance(solver):
    control = controller(robot("talos"), "both", solver=solver)
    drive(control, range(2))
    other = copy.deepcopy(control)
    for a, b in zip(drive(control, range(3)), drive(other, range(3)), strict=True):
        np.testing.assert_allclose(a.tau, b.tau, atol=1e-3)


def test_gains_of_a_copied_task_are_still_checked():
    task = copy.deepcopy(wbc.ComTask())
    with pytest.raises(ValueError, match="read-only"):
        task.weight[0] = -1.0


def test_a_pickled_controller_continues_in_another_process(tmp_path):
    control = controller(robot("talos"), "both", solver="wbc", formulation=wbc.Formulation.COMPILED)
    drive(control, range(3))
    (tmp_path / "controller").write_bytes(pickle.dumps(control))
    code = f"""
import pickle, numpy as np
from pathlib import Path
folder = Path({str(tmp_path)!r})
control = pickle.loads((folder / "controller").read_bytes())
from coretools import standing_state
np.save(folder / "tau.npy", control.step(standing_state(control.robot, 50)).tau)
"""
    subprocess.run([sys.executable, "-c", code], check=True, env=_environment())
    tau = control.step(standing_state(control.robot, 50)).tau
    np.testing.assert_array_equal(np.load(tmp_path / "tau.npy"), tau)


def _environment() -> dict[str, str]:
    import os

    return {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
