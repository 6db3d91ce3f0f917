"""Contacts: frames that the ground holds, and the forces they may bear."""

from wbc.contacts.contact import Contact
from wbc.contacts.point import PointContact
from wbc.contacts.surface import SurfaceContact

__all__ = ["Contact", "PointContact", "SurfaceContact"]
