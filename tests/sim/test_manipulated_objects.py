"""Payloads, walls and carts: what a robot carries, leans on and pushes."""

from __future__ import annotations

import copy

import numpy as np
import pinocchio as pin
import pytest
from coretools import robot

from wbc.errors import FrameNotFound, PlantError
from wbc.robot.upper_body import UpperBody
from wbc.sim import Cart, Mujoco, Wall


def dense_mass_matrix(plant):
    import mujoco

    M = np.zeros((plant.model.nv, plant.model.nv))
    mujoco.mj_forward(plant.model, plant.data)
    mujoco.mj_fullM(plant.model, plant.data, M)
    return M


def test_a_payload_adds_the_inertia_of_a_ball_and_is_gone_after_a_reset():
    bot = robot("simple_humanoid")
    hand = UpperBody.of(bot).arm("left").hand
    plant = Mujoco(bot, collisions="soles")
    before = dense_mass_matrix(plant)
    plant.schedule_payload(0.0, 2.0, hand)
    plant.step(_no_torque(bot))
    plant.data.qpos[:], plant.data.qvel[:] = plant.coordinates.to_plant(bot.standing())
    model = bot.model.copy()
    frame = model.frames[bot.frame_id(hand)]
    at = pin.SE3(np.eye(3), frame.placement.translation)
    model.inertias[frame.parentJoint] += at.act(pin.Inertia.FromSphere(2.0, 0.05))
    M = pin.crba(model, model.createData(), bot.q_nominal)
    M = np.triu(M) + np.triu(M, 1).T
    order = 6 + plant.coordinates.order
    np.testing.assert_allclose(dense_mass_matrix(plant)[np.ix_(order, order)], M[6:, 6:], atol=1e-9)
    plant.reset()
    np.testing.assert_allclose(dense_mass_matrix(plant), before, atol=1e-12)


def test_a_plant_with_a_payload_to_come_goes_on_identically_as_a_copy():
    bot = robot("simple_humanoid")
    plant = Mujoco(bot, collisions="soles")
    plant.schedule_payload(0.004, 2.0, UpperBody.of(bot).arm("left").hand)
    other = copy.deepcopy(plant)
    for _ in range(5):
        plant.step(_no_torque(bot))
        other.step(_no_torque(bot))
    np.testing.assert_array_equal(plant.data.qpos, other.data.qpos)
    assert plant.model.body_mass.sum() == pytest.approx(bot.mass + 2.0)


def test_bad_payloads_are_refused():
    bot = robot("simple_humanoid")
    plant = Mujoco(bot, collisions="soles")
    hand = UpperBody.of(bot).arm("left").hand
    with pytest.raises(PlantError, match=r"payload of -1 kg: the mass must be finite"):
        plant.schedule_payload(0.0, -1, hand)
    with pytest.raises(PlantError, match=r"the time is 0.000 s already"):
        plant.schedule_payload(-1.0, 1.0, hand)
    with pytest.raises(FrameNotFound):
        plant.schedule_payload(0.0, 1.0, "no_hand")


@pytest.mark.parametrize(
    ("towards", "face"), [("front", (0.4, 0.0)), ("left", (0.0, 0.4)), ("right", (0.0, -0.4))]
)
def test_the_face_of_a_wall_is_at_its_distance(towards, face):
    ((x, y, z, a, b, c),) = Wall(distance=0.4, towards=towards, height=1.0, bottom=0.8).boxes()
    assert (z - c, z + c) == pytest.approx((0.8, 1.0))
    near = [
        x - a * np.sign(face[0]) if face[0] else 0.0,
        y - b * np.sign(face[1]) if face[1] else 0.0,
    ]
    assert near == pytest.approx(list(face))
    assert max(a, b) == pytest.approx(1.5)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"distance": 0.0}, "distance is 0.0, it must be positive"),
        ({"towards": "up"}, "must be one of front, left, right"),
        ({"bottom": 3.0}, r"bottom = 3.0 m must be in \[0, 2.0\)"),
        ({"friction": -1.0}, "friction = -1.0 must be finite"),
    ],
)
def test_an_impossible_wall_is_refused(change, text):
    with pytest.raises(PlantError, match=text):
        Wall(**change)


def test_a_cart_starts_in_front_of_the_robot_and_rolls_when_pushed_hard_enough():
    bot = robot("simple_humanoid")
    plant = Mujoco(bot, collisions="soles", cart=Cart(distance=1.0, rolling_resistance=15.0))
    start = bot.standing()
    start.q[:7] = pin.SE3ToXYZQUAT(
        pin.SE3(pin.utils.rpyToMatrix(0.0, 0.0, np.pi / 2), np.array([2.0, 3.0, 0.0]))
        * pin.XYZQUATToSE3(bot.q_nominal[:7])
    )
    plant.reset(start)
    np.testing.assert_allclose(plant.data.body("cart").xpos[:2], [2.0, 4.01], atol=1e-9)
    for force, least, most in ((10.0, 0.0, 1e-3), (30.0, 0.01, 0.1)):
        before = plant.cart_position
        other = copy.deepcopy(plant)
        for one in (plant, other):
            for _ in range(100):
                one.data.qfrc_applied[-1] = force
                one.step(_no_torque(bot))
        np.testing.assert_array_equal(other.data.qpos, plant.data.qpos)
        assert least <= plant.cart_position - before <= most
    plant.reset()
    assert plant.cart_position == 0.0


def test_an_impossible_cart_is_refused():
    with pytest.raises(PlantError, match=r"Cart: mass is -1.0, it must be positive"):
        Cart(mass=-1.0)


def _no_torque(bot):
    from wbc.command import Command

    return Command(np.zeros(bot.na), np.zeros(bot.nv), {}, bot.q_nominal[7:], np.zeros(bot.na))
