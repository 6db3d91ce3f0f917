"""The standard pictures of a log."""

from wbc.log.pictures.standard import KINDS, plot

__all__ = ["KINDS", "plot"]
