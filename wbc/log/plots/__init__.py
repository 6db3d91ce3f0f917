"""The plots of a log."""

from wbc.log.plots.standard import KINDS, plot

__all__ = ["KINDS", "plot"]
