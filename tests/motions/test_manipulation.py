"""Hands that press, carry and push, in physics."""

from __future__ import annotations

import re

import numpy as np
import pytest
from coretools import robot

import wbc
from wbc.errors import MotionError
from wbc.motions import Brace, Carry, HoldHand, MotionPlayer, PushCart
from wbc.robot.upper_body import UpperBody
from wbc.sim import Cart, Mujoco, Wall
from wbc.trials import MotionRunner


def play(bot, motion, observe=lambda player, plant: None, **options):
    player = MotionPlayer(bot, motions=[motion])
    runner = MotionRunner(player)
    with Mujoco(bot, **options) as plant:

        def tick(time):
            observe(player, plant)
            runner(time, plant)

        report = wbc.run(player, plant, 60.0, before_tick=tick)
    assert report.survived, report.table()
    assert report.qp_failures == 0
    assert report.torque_excess_nm <= 0.0
    return player


@pytest.mark.slow
def test_a_hand_on_the_wall_carries_a_centre_of_mass_beyond_the_toes():
    bot = robot("g1")
    reach, touching = [0.0], set()

    def observe(player, plant):
        body = plant.model.geom_bodyid
        for pair in plant.data.contact.geom:
            names = {plant.model.body(int(body[geom])).name for geom in pair}
            touching.update(names - {"terrain"} if "terrain" in names else ())
        com = wbc.Kinematics(bot, plant.ground_truth()).p_com
        reach[0] = max(reach[0], float(com[0]) - bot.soles[0].half_length)

    player = play(bot, Brace(lean=0.15), observe, terrain=Wall(), seed=1)
    assert not player.aborted_motions, player.context.notes
    assert reach[0] > 0.05
    assert touching == {"left_wrist_yaw_joint"}
    assert player.steps == 0


@pytest.mark.slow
def test_a_hand_that_meets_no_wall_gives_up():
    player = play(robot("g1"), Brace(), seed=0)
    assert player.aborted_motions == ("brace",)
    assert "the left hand feels no surface within 20 cm" in player.context.notes


@pytest.mark.slow
@pytest.mark.parametrize(("name", "mass"), [("g1", 2.0), ("g1", 4.0), ("talos", 5.0)])
def test_the_mass_of_a_payload_is_known_within_ten_percent_while_walking(name, mass):
    player = play(robot(name), Carry(mass=mass, seconds=3.0), seed=1)
    assert not player.aborted_motions, player.context.notes
    told = [float(re.findall(r"[\d.]+(?= kg)", note)[0]) for note in player.context.notes]
    np.testing.assert_allclose(told, mass, rtol=0.1)
    assert player.steps > 4


@pytest.mark.slow
@pytest.mark.parametrize("name", ["g1", "talos"])
def test_a_hand_stays_at_its_place_in_the_world_while_the_feet_step(name):
    bot = robot(name)
    hand, places = UpperBody.of(bot).arm("left").hand, []

    def observe(player, plant):
        if player.steps and not player.context.standing:
            kin = wbc.Kinematics(bot, plant.ground_truth())
            places.append(kin.frame(hand).translation.copy())

    player = play(bot, HoldHand(), observe, seed=0)
    assert not player.aborted_motions, player.context.notes
    assert player.steps >= 6
    off = np.linalg.norm(places - np.mean(places, axis=0), axis=1)
    assert off.max() < 0.03


@pytest.mark.slow
def test_a_cart_is_pushed_with_the_force_that_is_asked_for():
    forces, moved = [], []

    def observe(player, plant):
        moved.append(plant.cart_position)
        if player.steps > 1 and not player.context.standing and len(moved) % 10 == 0:
            forces.append(-sum(f[0] for at, f in plant.contacts() if at[2] > 0.3))

    player = play(robot("g1"), PushCart(force=20.0), observe, cart=Cart(), seed=1)
    assert not player.aborted_motions, player.context.notes
    assert moved[-1] > 0.5
    assert np.mean(forces) == pytest.approx(20.0, abs=4.0)


@pytest.mark.slow
def test_what_an_arm_cannot_do_is_refused_before_it_starts():
    bot = robot("g1")
    with pytest.raises(
        MotionError, match=r"100 kg is more than the left arm of g1 bears .* kg, by"
    ):
        Carry(mass=100.0).prepare(bot)
    with pytest.raises(MotionError, match=r"does not reach a wall 2 m away \(\d+ cm short\)"):
        Brace(distance=2.0).prepare(bot)
    with pytest.raises(MotionError, match=r"500 N is more than the arms of g1 exert there: \d+ N"):
        PushCart(force=500.0).prepare(bot)
    with pytest.raises(MotionError, match=r"lead 200 cm away from the hand: at most 14 cm"):
        HoldHand(speed=1.0, leg=2.0).prepare(bot)
    with pytest.raises(MotionError, match=r"lean = -0.1 m must not be negative"):
        Brace(lean=-0.1).prepare(bot)
