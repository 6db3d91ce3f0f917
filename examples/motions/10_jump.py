"""Jump: plan within the robot's limits, jump, and measure the flight in the true state.

The plan is a path of configurations without angular momentum: the robot takes off, flies and lands
along it without rotation. A jump that is too high is refused.
"""

import wbc
from wbc.motions.jump import Jump
from wbc.motions.jumping import JumpTooHigh
from wbc.trials import run_motions

CLEARANCE = 0.06  # m, of both soles

robot = wbc.load("g1")
jump = Jump(clearance=CLEARANCE)

plan = jump.plan(robot)
print(f"crouch to {plan.lowest:.3f} m, push off for {plan.push_off.duration:.2f} s")
print(f"take off with {plan.speed:.2f} m/s, fly for {plan.flight.duration:.2f} s")
print(f"{100 * plan.torque_share:.0f} % of the torque of {plan.torque_joint} at most")

report = run_motions(robot, [jump], seed=1)  # noisy sensors, no ground truth in the loop
print(report.table())

flight = report.flights[0]
print(f"\nballistic rise v²/2g {1e3 * flight.take_off_speed_m_s**2 / 19.62:.1f} mm")
print(f"        true rise    {flight.rise_mm:.1f} mm")

try:
    Jump(clearance=1.0).check(robot)
except JumpTooHigh as refusal:
    print(f"\n{refusal}")
