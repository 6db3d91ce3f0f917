"""A run as one page that opens offline: figures, plots, events, parameters and a film."""

from wbc.log.report.key_figures import KeyFigure, key_figures
from wbc.log.report.page import report_page, save_report

__all__ = ["KeyFigure", "key_figures", "report_page", "save_report"]
