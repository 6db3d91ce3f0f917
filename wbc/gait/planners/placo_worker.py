"""The process of the `PlacoPlanner`: a plan for each request."""

from __future__ import annotations

from wbc.gait.planners.placo_program import plan_com
from wbc.process.parent import ParentConnection

_POLL = 0.5  # s between two looks at whether the parent has died


def main() -> None:
    """Reply to the requests of the parent process until it ends."""
    parent = ParentConnection()
    parent.listen(lambda request: parent.reply({"plan": plan_com(request)}))
    while not parent.gone:
        parent.wait(_POLL)


if __name__ == "__main__":
    main()
