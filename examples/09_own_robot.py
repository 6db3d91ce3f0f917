"""Load your own URDF: name the feet, inspect the derived properties, and walk.

The same properties can be given in a small data file: see `robots/*.toml`.
"""

from pathlib import Path

import wbc

urdf = Path(__file__).resolve().parents[1] / "robots" / "simple_humanoid.urdf"
legs = {"hip_pitch": -0.21, "knee": 0.5, "ankle_pitch": -0.29}  # rad
robot = wbc.load(
    urdf,
    left_foot="left_foot",
    right_foot="right_foot",
    nominal_posture={f"{side}_{j}": q for side in ("left", "right") for j, q in legs.items()},
    armature=0.02,  # kg·m², rotor inertia at the joints
    name="mine",
)

for fact in robot.facts:
    print(fact)
for finding in robot.check():  # the model doctor
    print(finding)

walker = wbc.Walker(robot)
walker.velocity = (0.2, 0.0, 0.0)
with wbc.sim.Mujoco(robot) as plant:
    print(wbc.run(walker, plant, duration=3.0).table())
