"""The show: everything that a robot can do, in a row, watched in the browser."""

import wbc
from wbc.motions import Performer, Show
from wbc.trials import MotionRunner

robot = wbc.load("talos")
performer = Performer(robot, motions=[Show()])
runner = MotionRunner(performer)  # applies the push that `one_leg` asks for; ends the run

with wbc.sim.Mujoco(robot) as plant, wbc.view.Meshcat(robot) as viewer:  # prints its address
    report = wbc.run(
        performer,
        plant,
        duration=180.0,
        viewer=viewer,
        before_tick=lambda time: runner(time, plant),
    )
print(report.table())
for note in performer.body.notes:
    print(note)
