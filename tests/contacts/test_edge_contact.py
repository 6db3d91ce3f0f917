"""An edge holds its line, transmits what two points at its ends can, and lets the body turn."""

import numpy as np
import pinocchio as pin
import pytest
from coretools import many, robot
from hypothesis import given
from hypothesis import strategies as st

import wbc
from wbc.errors import ContactError

EDGES = {"toe": 1 + 0j, "heel": -1 + 0j, "left": 1j, "right": -1j}


@many
@given(st.floats(0.02, 0.3), st.floats(0.1, 1.2), st.integers(0, 2**31))
def test_a_force_is_in_the_cone_exactly_when_friction_at_both_ends_can_make_it(X, mu, seed):
    """Of two points, f_y and f_z at each end follow from the wrench; f_x is shared as f_z is."""
    rng = np.random.default_rng(seed)
    fz = rng.uniform(-0.2, 1.0, 2)
    fy = rng.uniform(-1.3, 1.3, 2) * mu * fz
    fx = rng.uniform(-1.3, 1.3) * mu * fz.sum()
    force = np.array([fx, fy.sum(), fz.sum(), X * (fz[1] - fz[0]), X * (fy[0] - fy[1])])
    cone = wbc.EdgeContact("edge", X, friction=mu * np.sqrt(2.0)).cone
    possible = fz.min() >= 0.0 and np.all(np.abs(fy) <= mu * fz) and abs(fx) <= mu * fz.sum()
    gap = max(-fz.min(), (np.abs(fy) - mu * fz).max(), abs(fx) - mu * fz.sum())
    if abs(gap) > 1e-9:
        assert bool((cone @ force).max() <= 1e-12) is bool(possible)


@pytest.mark.parametrize("edge", EDGES)
def test_the_line_of_the_edge_stays_and_the_body_may_turn_about_it(edge):
    bot = robot("talos")
    sole, outward = bot.soles[0], EDGES[edge]
    state = wbc.State(bot.q_nominal, 0.1 * np.random.default_rng(3).standard_normal(bot.nv))
    control = wbc.WholeBodyController(bot)
    control.add(wbc.ComTask(weight=1000.0)).acceleration[:] = (outward.real, outward.imag, 0.0)
    control.add(wbc.PostureTask(bot, weight=0.1))
    contact = wbc.EdgeContact.of_sole(sole, outward)
    control.set_contacts([contact])
    command = control.step(state)
    assert command.status is wbc.Status.OK
    kin = wbc.Kinematics(bot, state)
    jacobian, velocity, bias = contact.motion(kin)
    acceleration = jacobian @ command.acceleration + bias
    held = [0, 1, 2, 4, 5]
    np.testing.assert_allclose(acceleration[held], -contact.damping * velocity[held], atol=1e-7)
    assert abs(acceleration[3]) > 0.1  # it turns
    wrench = command.wrenches[sole.name]
    at_edge = contact.placement.actInv(pin.Force(wrench))
    assert abs(at_edge.angular[0]) < 1e-9
    assert at_edge.linear[2] > 0.3 * bot.weight
    torque = kin.mass_matrix @ command.acceleration + kin.bias_forces
    torque -= kin.motion_local(bot.frame_id(sole.name)).jacobian.T @ wrench
    np.testing.assert_allclose(torque[:6], 0.0, atol=1e-6)
    np.testing.assert_allclose(torque[6:], command.tau, atol=1e-6)


def test_the_edges_of_a_sole_are_where_it_ends():
    sole = robot("talos").soles[0]
    toe = wbc.EdgeContact.of_sole(sole, 1 + 0j)
    np.testing.assert_allclose(toe.placement.translation, [sole.half_length, 0.0, 0.0])
    assert toe.half_length == sole.half_width
    right = wbc.EdgeContact.of_sole(sole, -1j)
    np.testing.assert_allclose(right.placement.translation, [0.0, -sole.half_width, 0.0])
    assert right.half_length == sole.half_length
    for edge in EDGES.values():
        rotation = wbc.EdgeContact.of_sole(sole, edge).placement.rotation
        np.testing.assert_allclose(rotation[:, 1], [edge.real, edge.imag, 0.0])


def test_an_edge_without_a_length_is_refused():
    with pytest.raises(ContactError, match=r"half_length 0\.0 must be positive"):
        wbc.EdgeContact("left_sole", 0.0)
