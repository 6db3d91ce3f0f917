"""Time series of any quantity of a tick, for the strips of the live page."""

from __future__ import annotations

import contextlib
import json
import time
from typing import Any

import numpy as np
import tornado.web
import tornado.websocket

from wbc.runtime.schema import Schema


class SeriesSource:
    """The values of the quantities that pages ask for.

    Attributes:
        pages: connections that show a quantity.
        labels: label of every number of a tick -> its column, and its index in it.
    """

    def __init__(self) -> None:
        self.pages: set[SeriesSocket] = set()
        self._schema = Schema(())
        self.labels: dict[str, tuple[str, int]] = {}

    def attach(self, schema: Schema) -> None:
        """Offer the quantities of a stream."""
        if schema is self._schema:
            return
        self._schema = schema
        self.labels = {
            column.label(i): (column.name, i)
            for column in schema.columns
            for i in range(column.size)
        }

    def advance(self, ticks: np.ndarray) -> None:
        """Send the last tick's values to the pages."""
        if not self.pages or not len(ticks):
            return
        stamp = round(time.monotonic(), 3)
        for page in tuple(self.pages):
            found = self.labels.get(page.label)
            if found is not None:
                name, index = found
                value = float(np.atleast_1d(ticks[name][-1])[index])
                known = value if np.isfinite(value) else None
                page.send(json.dumps({"stamp": stamp, "value": known}))


class SeriesSocket(tornado.websocket.WebSocketHandler):
    """Sends one quantity to a page, which names it by its label."""

    def initialize(self, source: SeriesSource) -> None:
        self.source = source
        self.label = ""

    def on_message(self, message: str | bytes) -> None:
        self.label = message if isinstance(message, str) else ""
        self.source.pages.add(self)

    def send(self, text: str) -> None:
        """Send a text, unless the page is gone."""
        with contextlib.suppress(tornado.websocket.WebSocketClosedError):
            self.write_message(text)

    def on_close(self) -> None:
        self.source.pages.discard(self)


class SeriesList(tornado.web.RequestHandler):
    """The labels of all quantities, as a JSON list."""

    def initialize(self, source: SeriesSource) -> None:
        self.source = source

    def get(self) -> None:
        labels: list[Any] = list(self.source.labels)
        self.set_header("Content-Type", "application/json; charset=utf-8")
        self.set_header("Cache-Control", "no-store")
        self.finish(json.dumps(labels))
