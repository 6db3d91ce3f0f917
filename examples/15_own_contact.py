"""Write your own contact: the rows of its force cone. This one is a sole of any convex outline.

Friction is a twelve-sided cone instead of a pyramid. Any number of rows is allowed.
"""

import numpy as np

import wbc


class PolygonContact(wbc.Contact):
    """A flat sole whose centre of pressure stays within a convex polygon.

    An edge with outward normal n at a distance d from the frame's origin bounds the centre of
    pressure (−τ_y, τ_x)/f_z by `n_x (−τ_y) + n_y τ_x ≤ d f_z`.
    """

    motion_size = 6  # the contact transmits a force and a moment

    def __init__(self, frame, corners, **options):
        super().__init__(frame, **options)
        self.corners = np.asarray(corners)  # m, counter-clockwise, in the frame's x and y axes

    def make_cone(self, mu):
        """Rows of `cone @ (force, moment) ≤ 0`; mu is the coefficient of an inscribed pyramid."""
        rows = []
        inscribed = np.sqrt(2.0) * mu * np.cos(np.pi / 12)  # of the twelve-sided cone
        for angle in np.arange(12) * np.pi / 6:
            rows.append([np.cos(angle), np.sin(angle), -inscribed, 0, 0, 0])
        for corner, following in zip(self.corners, np.roll(self.corners, -1, 0), strict=True):
            along = (following - corner) / np.linalg.norm(following - corner)
            nx, ny = along[1], -along[0]
            rows.append([0, 0, -(nx * corner[0] + ny * corner[1]), ny, -nx, 0])
        radius = np.linalg.norm(self.corners, axis=1).min()
        rows += [[0, 0, -mu * radius, 0, 0, sign] for sign in (1, -1)]  # yaw torque, roughly
        return np.array(rows, dtype=float)

    @property
    def cone_labels(self):
        """Return one label per row, for explanations of infeasibility."""
        friction = [f"friction at {30 * k}°" for k in range(12)]
        edges = [f"edge {k}" for k in range(len(self.corners))]
        return (*friction, *edges, "yaw torque +", "yaw torque −")


robot = wbc.load("talos")
controller = wbc.WholeBodyController(robot)
controller.add(wbc.ComTask())
controller.add(wbc.PostureTask(robot))
contacts = []
for sole in robot.soles:
    x, y = sole.half_length, sole.half_width
    octagon = [(x, -y / 2), (x, y / 2), (x / 2, y), (-x / 2, y)]
    octagon += [(-a, -b) for a, b in octagon]
    contacts.append(PolygonContact(sole.name, octagon))
controller.set_contacts(contacts)
command = controller.step(robot.standing())
print(contacts[0], "with", len(contacts[0].cone), "rows:", command.status.value)
for name, (_, _, fz, mx, my, _) in command.wrenches.items():
    print(f"{name}: {fz:.0f} N, centre of pressure ({-my / fz:+.3f}, {mx / fz:+.3f}) m")
