"""What the page's process knows: what is offered, where everything stands, and who looks on."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from wbc.errors import MotionError
from wbc.live.errors import BadRequest
from wbc.live.gauges import SIZE, Gauges
from wbc.live.helm import RECORD
from wbc.live.order import Order
from wbc.live.panel import Kind, Request
from wbc.motions import Motion
from wbc.motions.engine.blob_buffer import SLOTS, BlobBuffer
from wbc.motions.engine.planning import MotionPlanner, PlannedMotion
from wbc.process import RecordRing

_OPEN = SLOTS - 1  # requests that the loop may owe


class Visitor(Protocol):
    """An open page."""

    def say(self, text: str) -> None:
        """Send it something; never waits."""


@dataclass(frozen=True)
class _Wish:
    """A motion that is being planned, and who wants it."""

    motion: Motion
    sender: Visitor


class Desk:
    """Passes requests of the pages on to the loop, and tells the pages what becomes of them.

    A motion goes to the loop when it has been planned, unless something else was wanted
    meanwhile.

    Args:
        order: what the process was told.
        later: calls a function soon, from any thread, where everything else here is called.
    """

    def __init__(self, order: Order, later: Callable[[Callable[[], None]], None]) -> None:
        self.panel = order.panel
        self._gauges = RecordRing(SIZE, order.gauges)
        self._requests = RecordRing(RECORD, order.requests)
        self._shelf = BlobBuffer(order.shelf)
        self._sent = self._taken = 0
        self._run = 0
        self.values = {knob.name: knob.value for knob in order.panel.knobs}
        self.visitors: set[Visitor] = set()
        #: Motion -> why the robot cannot do it as it is by default.
        self.unable: dict[str, str] = {}
        self._wish: _Wish | None = None
        self._planner = MotionPlanner(
            order.robot, order.panel.motions, lambda plan: later(lambda: self._planned(plan))
        )

    def start_planning(self) -> None:
        """Begin with the motions as they are by default."""
        self._planner.start()

    def ask(self, message: str | bytes, sender: Visitor) -> None:
        """Take a page's message; what is wrong with it is its answer."""
        try:
            request = self.panel.request(message)
            if request.motion is not None:
                self._wish_for(request.motion, sender)
            else:
                self._pass_on(request, sender)
        except BadRequest as error:
            _answer(sender, {"error": str(error)})

    def _wish_for(self, motion: Motion, sender: Visitor) -> None:
        self._forget_wish()
        self._wish = _Wish(motion, sender)
        plan = self._planner.cached(motion)
        if plan is not None:
            self._planned(plan)
            return
        _answer(sender, {"planning": motion.name})
        self._planner.request(motion)

    def _planned(self, plan: PlannedMotion) -> None:
        name = plan.motion.name
        if plan.error and name not in self.unable and self._planner.cached(plan.motion):
            self.unable[name] = plan.error
            self.tell({"unable": self.unable})
        wish = self._wish
        if wish is None or wish.motion != plan.motion:
            return
        self._forget_wish()
        try:
            if plan.error:
                raise BadRequest(plan.error)
            self._check_open()
            slot = self._shelf.write(plan.packed)
        except (BadRequest, MotionError) as error:
            _answer(wish.sender, {"error": str(error)})
            return
        self._write(Kind.MOTION, slot, len(plan.packed))
        if not plan.motion.while_walking:
            self._let_stand()

    def _forget_wish(self) -> None:
        if self._wish is not None:
            self._planner.request(None)
            _answer(self._wish.sender, {"planning": None})
            self._wish = None

    def _pass_on(self, request: Request, sender: Visitor) -> None:
        """Give a request to the loop, and tell the other pages where a knob stands.

        Raises:
            BadRequest: the loop does not take any.
        """
        self._check_open()
        self._write(request.kind, request.first, request.second)
        if request.kind is Kind.KNOB:
            knob = self.panel.knobs[int(request.first)]
            self.values[knob.name] = request.second
            self.tell({"values": {knob.name: request.second}}, but=sender)
            drives = knob.group == "velocity" and request.second != 0.0
            if drives and self._wish is not None and not self._wish.motion.while_walking:
                self._forget_wish()
        elif request.kind in (Kind.STAND, Kind.RESET):
            self._forget_wish()
            self._let_stand()

    def _check_open(self) -> None:
        if self._sent - self._taken >= _OPEN:
            raise BadRequest("too many requests at once: the loop takes them between its ticks")

    def _write(self, *record: float) -> None:
        self._requests.begin()[:] = record
        self._requests.publish()
        self._sent += 1

    def _let_stand(self) -> None:
        """The velocity's knobs go back to zero, as the loop's wish does."""
        zeros = {k.name: 0.0 for k in self.panel.knobs if k.group == "velocity"}
        self.values.update(zeros)
        self.tell({"values": zeros})

    def advance(self) -> None:
        """Read the gauges, and tell the pages."""
        ticks = [Gauges.of(record) for record in self._gauges.read()]
        if not ticks:
            return
        last = ticks[-1]
        self._taken = last.taken
        if last.run != self._run:
            self._run = last.run
            self._let_stand()
        self.tell({"gauges": _summary(ticks)})

    def welcome(self, visitor: Visitor) -> None:
        """Tell a page what is offered and where everything stands, and what happens from now on."""
        _answer(visitor, {"panel": self.panel.describe()})
        _answer(visitor, {"values": self.values, "unable": self.unable})
        self.visitors.add(visitor)

    def tell(self, news: dict[str, Any], but: Visitor | None = None) -> None:
        """Say something to the pages."""
        text = json.dumps(news, separators=(",", ":"))
        for visitor in tuple(self.visitors):
            if visitor is not but:
                visitor.say(text)


def _answer(visitor: Visitor, news: dict[str, Any]) -> None:
    visitor.say(json.dumps(news))


def _summary(ticks: list[Gauges]) -> dict[str, Any]:
    """The last tick, with the worst of all of them."""
    last = ticks[-1]
    return {
        "stamp": round(time.monotonic(), 3),
        "time": round(last.time, 4),
        "mode": last.mode.name.lower(),
        "dcm_error": _rounded(max(tick.dcm_error for tick in ticks)),
        "tick_time": _rounded(max(tick.tick_time for tick in ticks)),
        "velocity": [_rounded(x) for x in (last.forward, last.left, last.turn)],
        "playing": last.playing,
        "pushes": last.pushes,
        "survived": last.survived,
        "run": last.run,
    }


def _rounded(value: float) -> float | None:
    return round(value, 6) if abs(value) < float("inf") else None
