"""Processes of our own beside the loop's: how they start, what they share, how they end."""

from wbc.process.child import Child, ChildError
from wbc.process.memory import SharedMemory
from wbc.process.records import RecordRing

__all__ = ["Child", "ChildError", "RecordRing", "SharedMemory"]
