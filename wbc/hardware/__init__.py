"""Robots outside this process: low-level interfaces, and the safety layer before them."""

from wbc.hardware.errors import HardwareError
from wbc.hardware.hardware import ConnectionState, Hardware, Reading
from wbc.hardware.safety.foot_load import feet_carry
from wbc.hardware.safety.limits import SafetyLimits
from wbc.hardware.safety.safe_hardware import SafeHardware
from wbc.hardware.safety.transitions import SafetyState, Transition
from wbc.hardware.unitree.g1 import UnitreeG1

__all__ = [
    "ConnectionState",
    "Hardware",
    "HardwareError",
    "Reading",
    "SafeHardware",
    "SafetyLimits",
    "SafetyState",
    "Transition",
    "UnitreeG1",
    "feet_carry",
]
