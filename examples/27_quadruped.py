"""Sway, squat, trot forward, sideways and in a turn on four feet, and take a push.

`wbc.load` finds the four feet; `wbc.QuadrupedWalker` has the interface of `wbc.Walker`.
"""

import math

import wbc
from wbc.walking import ReferenceOffset

MOTOR = 2.7  # N·m; the URDF states no limit that a motor of this robot has
DURATION, PUSH = 5.0, 1.0  # s, N·s
SWAY, SQUAT = 0.02, 0.03  # m
VELOCITIES = ((0.28, 0.0, 0.0), (0.0, 0.14, 0.0), (0.0, 0.0, 0.7))  # m/s, m/s, rad/s; 1 s each

joints = wbc.load("solo12").joint_names
robot = wbc.load("solo12", effort_limits=dict.fromkeys(joints, MOTOR), armature=5e-4)
walker = wbc.QuadrupedWalker(robot)


def command(time: float) -> None:
    """Sway and squat for a second, then trot, then stand."""
    k = int(time) - 1
    walker.velocity = VELOCITIES[k] if 0 <= k < len(VELOCITIES) else (0.0, 0.0, 0.0)
    offset = walker.reference_offset = ReferenceOffset() if time < 1.0 else None
    if offset is not None:
        offset.com[1] = SWAY * math.sin(2.0 * math.pi * time)
        offset.com[2] = -0.5 * SQUAT * (1.0 - math.cos(2.0 * math.pi * time))


with wbc.sim.Mujoco(robot) as plant:
    plant.schedule_push(2.5, (0.0, PUSH, 0.0))
    report = wbc.run(walker, plant, DURATION, before_tick=command)

print(report)
x, y = report.displacement_m
print(f"trotted {report.steps} steps to ({x:.2f}, {y:.2f}) m")
