"""The standard pictures of a log."""

from wbc.log.plot.pictures import KINDS, plot

__all__ = ["KINDS", "plot"]
