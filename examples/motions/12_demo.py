"""Demo: all motions of a robot in sequence, shown in the browser."""

import wbc
from wbc.motions import Demo, MotionPlayer
from wbc.trials import MotionRunner

robot = wbc.load("talos")
player = MotionPlayer(robot, motions=[Demo()])
runner = MotionRunner(
    player
)  # applies the push that standing on one leg requests, and ends the run

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
