"""Contacts: frames held by the environment, and the contact forces they can transmit."""

from wbc.contacts.contact import Contact
from wbc.contacts.edge import EdgeContact
from wbc.contacts.point import PointContact
from wbc.contacts.surface import SurfaceContact

__all__ = ["Contact", "EdgeContact", "PointContact", "SurfaceContact"]
