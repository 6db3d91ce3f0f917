"""Walk a robot whose joints are position servos: soft, late, with friction and backlash.

A servo exerts `tau + kp (q − q_measured) + kd (v − v_measured)`. `Command.servo(gains)` gives what
a servo takes; here the plant models such servos. The last robot is a hybrid: its legs take torques,
all other joints positions.
"""

import wbc
from wbc.sim import JointServos, Mujoco

robot = wbc.load("talos")
gains = wbc.ServoGains.for_robot(robot)
print(gains)
legs = [name for name in robot.joint_names if name.startswith("leg")]
for kind, servo_gains in (
    ("position servos", gains),
    ("torque for the legs", gains.with_torque_control(robot, legs)),
):
    walker = wbc.Walker(robot, dt=0.004)  # 250 Hz; the servos run at the physics' 1 kHz
    walker.velocity = (0.3, 0.0, 0.0)
    servos = JointServos(servo_gains, friction=0.03)  # and a backlash of 0.5°
    plant = Mujoco(robot, dt=walker.dt, latency=0.002, servos=servos)
    report = wbc.run(walker, plant, 4.0)
    print(f"{kind}: survived {report.survived}, {report.distance_m:.2f} m, {report.steps} steps")
