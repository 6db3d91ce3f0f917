"""A robot that is pushed while its weight moves to the front foot: which foot carries it then."""

from __future__ import annotations

from dataclasses import replace

import pytest

import wbc
from wbc.gait import DcmReference, Phase
from wbc.walking.stabilizer.support_choice import has_to_return

STEP = 0.2  # m by which the right foot is behind the left one


def walker_in_transfer(name: str) -> wbc.Walker:
    """A walker whose weight begins to move to the left foot, which is in front."""
    walker = wbc.Walker(wbc.load(name))
    state = walker.gait_state
    rear = state.feet.right
    state.feet = replace(state.feet, right=rear._replace(point=rear.point - STEP))
    state.phase, state.support, state.starting = Phase.TRANSFER, "left", False
    state.duration = state.gait.double_support
    state.dcm = state.feet.middle
    return walker


@pytest.mark.parametrize("name", ["g1", "talos", "simple_humanoid"])
@pytest.mark.parametrize(
    ("along", "across", "returns"),
    [(-0.25, 0.0, True), (0.25, 0.0, False), (0.0, 0.1, False), (0.0, -0.1, False)],
)
def test_the_weight_returns_to_the_rear_foot_only_after_a_push_back(name, along, across, returns):
    walker = walker_in_transfer(name)
    state = walker.gait_state
    state.dcm += complex(along, across)
    assert has_to_return(state, walker.stabilizer.support) is returns


def test_a_push_that_lasts_counts_before_the_dcm_has_moved():
    walker = walker_in_transfer("g1")
    state, support = walker.gait_state, walker.stabilizer.support
    state.dcm -= 0.12
    assert not has_to_return(state, support)
    state.disturbance = -3.0 + 0j
    assert has_to_return(state, support)


@pytest.mark.parametrize(("push", "swing"), [(-0.25, "left"), (0.25, "right")])
def test_the_front_foot_steps_when_the_weight_has_to_return(push, swing):
    walker = walker_in_transfer("g1")
    state, machine = walker.gait_state, walker.state_machine
    walker.velocity = (0.2, 0.0, 0.0)
    planned = DcmReference(state.dcm, 0j, state.dcm)
    state.dcm += push
    walker.stabilizer.push_recovery.update_transfer(state, planned, lambda _: planned, (0.05, 0.02))
    assert state.shortened
    for _ in range(100):
        machine.update(0.002, state.feet, walker._command, None)
        if state.phase is Phase.SWING:
            break
    assert state.phase is Phase.SWING
    assert state.swing_side == swing
