"""Processes: children of the control loop's process, and the memory that they share with it."""

from wbc.process.blobs import BlobQueue, BlobQueueFull, BlobTooLarge
from wbc.process.child import ChildProcess, ProcessStartError
from wbc.process.memory import SharedMemory
from wbc.process.parent import ParentConnection
from wbc.process.ring import RingReader, SharedRing

__all__ = [
    "BlobQueue",
    "BlobQueueFull",
    "BlobTooLarge",
    "ChildProcess",
    "ParentConnection",
    "ProcessStartError",
    "RingReader",
    "SharedMemory",
    "SharedRing",
]
