"""Demo: everything that a robot can do, in a row, watched in the browser."""

import wbc
from wbc.motions import Demo, MotionPlayer
from wbc.trials import MotionRunner

robot = wbc.load("talos")
player = MotionPlayer(robot, motions=[Demo()])
runner = MotionRunner(
    player
)  # grants the light push that standing on one leg asks for; ends the run

with wbc.sim.Mujoco(robot) as plant, wbc.view.Meshcat(robot) as viewer:  # prints its address
    report = wbc.run(
        player,
        plant,
        duration=180.0,
        observers=[viewer],
        before_tick=lambda time: runner(time, plant),
    )
print(report.table())
for note in player.context.notes:
    print(note)
