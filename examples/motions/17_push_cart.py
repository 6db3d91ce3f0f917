"""Push a cart of 15 kg with a given force of both hands, and walk behind it."""

import wbc
from wbc.motions import MotionPlayer, PushCart
from wbc.sim import Cart, Mujoco
from wbc.trials import MotionRunner

robot = wbc.load("g1")
player = MotionPlayer(robot, motions=[PushCart(force=20.0, walk=0.15)])
with Mujoco(robot, cart=Cart(mass=15.0, rolling_resistance=15.0), seed=0) as plant:
    runner = MotionRunner(player)
    report = wbc.run(player, plant, 30.0, before_tick=lambda time: runner(time, plant))
    print(f"the cart has moved by {plant.cart_position:.2f} m")
print(report)
print(*player.context.notes, sep="\n")
