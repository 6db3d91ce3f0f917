"""A page of the soak: it draws nothing, and counts what it sent and what was answered."""

from __future__ import annotations

import asyncio
import contextlib
import json
import time
from typing import Any

from shared.clients import socket_address


class Page:
    """An open page: its scene and its control connection.

    Attributes:
        sent: Commands sent so far.
        outcomes: Outcomes by the number of the command, in order of arrival.
        errors: Refusals without an outcome, and messages to all pages.
        status: The last status; empty before the first one.
        velocity_zero: When the status last showed a velocity command of zero, s by the monotonic
            clock; NaN while it shows another one.
        controls: What the server says that it can be asked for.
    """

    def __init__(self) -> None:
        self.sent = 0
        self.outcomes: dict[int, list[str]] = {}
        self.errors: list[str] = []
        self.reasons: set[str] = set()
        self.status: dict[str, Any] = {}
        self.controls: dict[str, Any] = {}
        self.saved: list[str] = []
        self._tasks: list[asyncio.Task[None]] = []
        self._reading = asyncio.Event()
        self._reading.set()

    @classmethod
    async def open(cls, url: str) -> Page:
        """Connect, and wait for the description of the controls."""
        from tornado.websocket import websocket_connect

        page = cls()
        page._control = await websocket_connect(socket_address(url, "controls"))
        page._scene = await websocket_connect(
            socket_address(url, "socket"), max_message_size=1 << 28
        )
        page._tasks = [
            asyncio.create_task(page._receive_controls()),
            asyncio.create_task(page._receive_scene()),
        ]
        while not page.controls and not page.lost:
            await asyncio.sleep(0.02)
        return page

    @property
    def lost(self) -> bool:
        """Whether the connection has ended."""
        return any(task.done() for task in self._tasks)

    @property
    def answered(self) -> int:
        """Commands that have been acknowledged or refused."""
        return len(self.outcomes) + sum(error not in self.reasons for error in self.errors)

    def send(self, control: str, value: object = None, *, valid: bool = True) -> None:
        """Send a request; a command is counted."""
        self.send_text(json.dumps({"control": control, "value": value}))
        self.sent += valid

    def send_text(self, text: str) -> None:
        """Send any text."""
        from tornado.websocket import WebSocketClosedError

        with contextlib.suppress(WebSocketClosedError):
            self._control.write_message(text)

    async def settle(self, timeout: float) -> None:
        """Wait until all commands have been answered, at most `timeout` s."""
        end = time.monotonic() + timeout
        while self.answered < self.sent and not self.lost and time.monotonic() < end:
            await asyncio.sleep(0.05)

    def stop_reading(self) -> None:
        """Let the messages of both connections pile up."""
        self._reading.clear()

    def read_on(self) -> None:
        """Read again."""
        self._reading.set()

    async def close(self) -> None:
        """Close the connections as a browser does."""
        self.read_on()
        self._control.close()
        self._scene.close()
        await asyncio.wait(self._tasks, timeout=5.0)
        self.kill()

    def kill(self) -> None:
        """End the connections without a word, as a killed browser does."""
        for connection in (self._control, self._scene):
            protocol = connection.protocol
            if protocol is not None:
                protocol._abort()
        for task in self._tasks:
            task.cancel()

    async def _receive_controls(self) -> None:
        while (text := await self._control.read_message()) is not None:
            await self._reading.wait()
            message = json.loads(text)
            if "controls" in message:
                self.controls = message["controls"]
            if "status" in message:
                self.status = message["status"]
            if "outcome" in message:
                self.outcomes.setdefault(message["id"], []).append(message["outcome"])
                if message["reason"]:
                    self.reasons.add(message["reason"])
            if message.get("saved"):
                self.saved.append(message["saved"])
            elif "error" in message:
                self.errors.append(message["error"])

    async def _receive_scene(self) -> None:
        while (message := await self._scene.read_message()) is not None:
            await self._reading.wait()
            if isinstance(message, str) and ("paths" in message or "caption" in message):
                await self._scene.write_message("frame")
