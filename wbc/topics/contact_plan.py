"""Topics of the contact plan: support polygon, footsteps and the swing foot's path."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from wbc.messages import message_type
from wbc.runtime.record import used_rows
from wbc.runtime.schema import ODOM
from wbc.telemetry import SIDES
from wbc.topics.batch import TickBatch
from wbc.topics.template import MessageTemplate
from wbc.topics.topic import MessageBlock, MessageTopic

#: Numbers of the elements of a message, shape (k, m), by the paths of their fields in an element.
Elements = Mapping[str, np.ndarray]


class ContactPlanTopic(MessageTopic):
    """A topic with one message per new contact plan, about 30 per second.

    Args:
        name: Name of the topic.
        type_name: Type of its messages.
        sequence: Field of the messages that holds the elements.
        element_type: Type of the elements.
        elements: Returns the elements of the plan in a record.
    """

    def __init__(
        self,
        name: str,
        type_name: str,
        sequence: str,
        element_type: str,
        elements: Callable[[Any], Elements],
    ) -> None:
        super().__init__(name, type_name)
        self._sequence, self._element_type, self._elements = sequence, element_type, elements
        self._templates: dict[int, MessageTemplate] = {}  # by the number of elements
        self._latest = (0.0, 0.0)  # run and tick of the latest published plan

    def messages(self, batch: TickBatch) -> list[MessageBlock]:
        """Return the messages of a batch; see `MessageTopic.messages`."""
        plans: defaultdict[int, list[tuple[int, Elements]]] = defaultdict(list)
        for tick in self._new_plans(batch.records):
            elements = self._elements(batch.records[tick])
            plans[len(next(iter(elements.values())))].append((tick, elements))
        blocks = []
        for count, members in plans.items():
            ticks = np.array([tick for tick, _ in members])
            values = {
                f"{self._sequence}[{{}}]{path}": np.stack([one[path] for _, one in members])
                for path in members[0][1]
            }
            data = self._template(count).fill(batch.stamps[ticks], values)
            blocks.append(MessageBlock(ticks, data))
        return blocks

    def _new_plans(self, records: np.ndarray) -> list[int]:
        """Return the indices of the records in which a contact plan appears."""
        plans = zip(records["run"].tolist(), records["contact_plan_tick"].tolist(), strict=True)
        found = []
        for index, plan in enumerate(plans):
            if plan != self._latest and not np.isnan(plan[1]):
                self._latest = plan
                found.append(index)
        return found

    def _template(self, count: int) -> MessageTemplate:
        """Return the template of a message with a number of elements."""
        if count not in self._templates:
            message: Any = message_type(self.type_name)()
            elements: Any = [message_type(self._element_type)() for _ in range(count)]
            for one in (message, *elements):
                if hasattr(one, "header"):
                    one.header.frame_id = ODOM
            *path, field = self._sequence.split(".")
            holder = message
            for name in path:
                holder = getattr(holder, name)
            setattr(holder, field, elements)
            self._templates[count] = MessageTemplate(message)
        return self._templates[count]


def contact_plan_topics() -> list[ContactPlanTopic]:
    """Return the topics of the contact plan."""
    polygon, array, pose = (
        f"geometry_msgs/msg/{name}" for name in ("PolygonStamped", "PoseArray", "Pose")
    )
    point, stamped = "geometry_msgs/msg/Point32", "geometry_msgs/msg/PoseStamped"
    plan, footstep = "wbc_msgs/msg/FootstepPlan", "wbc_msgs/msg/Footstep"
    return [
        ContactPlanTopic("support_polygon", polygon, "polygon.points", point, _support),
        ContactPlanTopic("footsteps", plan, "footsteps", footstep, _footsteps),
        # The footsteps of each side once more, as a type that viewers draw.
        ContactPlanTopic("footsteps/left", array, "poses", pose, _left),
        ContactPlanTopic("footsteps/right", array, "poses", pose, _right),
        ContactPlanTopic("swing_path", "nav_msgs/msg/Path", "poses", stamped, _swing_path),
    ]


def _support(record: Any) -> Elements:
    """Return the counter-clockwise vertices of the support polygon."""
    return {"": used_rows(record["support"])}


def _footsteps(record: Any) -> Elements:
    """Return the planned footsteps, the next one first."""
    rows = used_rows(record["footsteps"])
    return {".side": rows[:, 0], ".pose": _poses(rows[:, 1:4], rows[:, 4])}


def _left(record: Any) -> Elements:
    return _footsteps_of("left", record)


def _right(record: Any) -> Elements:
    return _footsteps_of("right", record)


def _footsteps_of(side: str, record: Any) -> Elements:
    rows = used_rows(record["footsteps"])
    rows = rows[rows[:, 0] == SIDES.index(side)]
    return {"": _poses(rows[:, 1:4], rows[:, 4])}


def _swing_path(record: Any) -> Elements:
    """Return the remaining path of the swing sole's centre."""
    points = used_rows(record["swing_path"])
    return {".pose": _poses(points, np.zeros(len(points)))}


def _poses(positions: np.ndarray, yaw: np.ndarray) -> np.ndarray:
    """Return positions and quaternions x y z w of turns about z, shape (k, 7)."""
    zeros = np.zeros_like(yaw)
    turns = (zeros, zeros, np.sin(0.5 * yaw), np.cos(0.5 * yaw))
    return np.concatenate((positions, np.stack(turns, axis=1)), axis=1)
