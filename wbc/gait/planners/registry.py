"""Planners by name."""

from __future__ import annotations

from wbc.errors import PlannerNotFound, did_you_mean, short_repr
from wbc.gait.planners.dcm_planner import DcmPlanner
from wbc.gait.planners.mpc_planner import MpcPlanner
from wbc.gait.planners.placo_planner import PlacoPlanner
from wbc.gait.planners.planner import Planner
from wbc.gait.planners.preview_control_planner import PreviewControlPlanner
from wbc.robot import Robot

#: Names of the library's planners.
PLANNER_NAMES = ("dcm", "preview", "mpc", "placo")


def make_planner(name: str, robot: Robot) -> Planner:
    """Return a new planner by its name.

    Args:
        name: "dcm" (analytic), "preview" (preview control of the ZMP) or "mpc" (model-predictive
            control of ZMP and footsteps) or "placo" (placo's walk pattern in a process of its own).
        robot: the robot that it plans for.

    Raises:
        PlannerNotFound: there is no planner of that name.
    """
    if name == "dcm":
        return DcmPlanner()
    if name == "preview":
        return PreviewControlPlanner()
    if name == "mpc":
        return MpcPlanner(robot)
    if name == "placo":
        return PlacoPlanner(robot)
    raise PlannerNotFound(f"there is no planner '{name}'{did_you_mean(name, PLANNER_NAMES)}")


def resolve_planner(planner: str | Planner | None, robot: Robot) -> Planner:
    """Return the planner of a name (see `make_planner`), or the object itself.

    Args:
        planner: name or object; the analytic planner when left out.
        robot: the robot that it plans for.

    Raises:
        PlannerNotFound: see `make_planner`, or the object lacks a method of `Planner`.
    """
    if planner is None or isinstance(planner, str):
        return make_planner(planner or "dcm", robot)
    if isinstance(planner, type) or not isinstance(planner, Planner):
        raise PlannerNotFound(
            f"planner = {short_repr(planner)} is neither a name nor an object with the methods "
            "reset, next_swing, update, reference and footsteps; see wbc.gait.Planner"
        )
    return planner
