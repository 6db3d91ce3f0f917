"""Drive a simulated robot by commands from Python, like those of the live page and ROS 2."""

import wbc
from wbc.motions import MotionPlayer, Wave
from wbc.teleop import MotionCommand, PushCommand, StandCommand, VelocityCommand

robot = wbc.load("g1")
player = MotionPlayer(robot)
script = [
    (0.5, VelocityCommand(forward=0.2)),  # m/s
    (3.0, PushCommand((0.0, 2.0, 0.0))),  # N·s to the robot's left
    (3.5, StandCommand()),
    (5.5, MotionCommand(Wave(seconds=1.0))),
]

with (
    wbc.sim.Mujoco(robot) as plant,
    wbc.teleop.CommandHandler(player, plant, owns_clock=False) as handler,
):
    # An invalid command is refused at once, with the reason and the bounds.
    try:
        handler.submit(VelocityCommand(forward=20.0))
    except wbc.teleop.CommandRefused as error:
        print(error)

    # Each command is acknowledged: accepted, and for a motion done, superseded or aborted.
    handler.add_observer(lambda sent, ack: print(f"{ack.time:.3f} s: {sent} {ack.outcome.value}"))

    def submit_due(time: float) -> None:
        """Submit the commands that are due; they are applied before this tick."""
        while script and time >= script[0][0]:
            handler.submit(script.pop(0)[1])

    report = wbc.teleop.run(handler, 10.0, before_tick=submit_due, real_time=False)

assert report is not None
print(report.table())
