"""A robot in another size, as dynamic similarity asks for: what is similar moves alike."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

#: Exponents of the length: with equal density and gravity, times go with its square root.
MASS, INERTIA, TORQUE, SPEED = 3.0, 5.0, 4.0, -0.5


def scaled_urdf(source: Path, factor: float, target: Path) -> Path:
    """Write a URDF of boxes, cylinders and spheres in another size.

    Args:
        source: the URDF.
        factor: size over the original one.
        target: file to write.
    """
    tree = ET.parse(source)
    powers = {
        ("origin", "xyz"): 1.0,
        ("box", "size"): 1.0,
        ("sphere", "radius"): 1.0,
        ("cylinder", "radius"): 1.0,
        ("cylinder", "length"): 1.0,
        ("mass", "value"): MASS,
        ("limit", "effort"): TORQUE,
        ("limit", "velocity"): SPEED,
        **{("inertia", key): INERTIA for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")},
    }
    for (tag, key), power in powers.items():
        for element in tree.iter(tag):
            if key in element.attrib:
                numbers = [factor**power * float(word) for word in element.get(key, "").split()]
                element.set(key, " ".join(f"{number:.12g}" for number in numbers))
    tree.write(target)
    return target
