"""Ask why a command is what it is: which limits stood in the way of which task.

A hand is to accelerate upwards faster than the arm can, and the centre of mass (CoM) forwards
faster than the feet can push.
"""

import wbc

robot = wbc.load("talos")
controller = wbc.WholeBodyController(robot)
controller.set_contacts([wbc.SurfaceContact.from_sole(sole) for sole in robot.soles])
com = controller.add(wbc.ComTask())
hand = controller.add(wbc.PositionTask("gripper_left_base_link", name="hand", priority=2))
controller.add(wbc.PostureTask(robot, priority=3))

com.acceleration[0] = 3.0  # m/s²
hand.acceleration[2] = 60.0
why = controller.step(robot.standing()).explain()
print(why)

# The same as data: the row that costs the task of highest priority most.
row = why.active[0]
for gain in row.gains:
    print(f"per {row.unit} of {row.name}: {gain.name} {gain.change:.3g} {gain.unit} more")

# Exact tasks that exclude each other: the rows in conflict, and by how much each has to
# give way.
controller.add(wbc.ComTask(priority=0, name="stay"))
controller.add(wbc.ComTask(priority=0, name="go")).acceleration[0] = 1.0
why = controller.step(robot.standing()).explain()
print(why)
print([(row.name, round(row.violation, 3), row.unit) for row in why.conflict])
