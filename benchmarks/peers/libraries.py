"""The libraries that are compared."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Library:
    """One column of the comparison.

    Attributes:
        key: short name, in the JSON.
        label: for tables.
        adapter: "module:class" under `peers.adapters`.
        environment: name of its environment; None for the one that runs the comparison.
        versus: key of the configuration of ours that solves the same problem; None for ours.
        torques: False for velocity-level solvers, which are shown for scale only.
        differs: remaining differences of the problem.
    """

    key: str
    label: str
    adapter: str
    environment: str | None = None
    versus: str | None = None
    torques: bool = True
    differs: str = ""


LIBRARIES = (
    Library("wbc", "wbc", "wbc_controller:Wbc"),
    Library(
        "tsid",
        "TSID, eiquadprog-fast",
        "tsid_force:Tsid",
        "tsid",
        versus="wbc",
        differs="12 corner forces per foot instead of a wrench: the same cone, but the solver's "
        "1e-8 on each of them is a cost of its own where corners are unloaded, which moves force "
        "between two feet; 1e-8 on the base's acceleration; swing error log6 instead of "
        "(position, log3)",
    ),
    Library("wbc-placo", "wbc, placo's problem", "wbc_controller:WbcLikePlaco"),
    Library(
        "placo",
        "placo DynamicsSolver",
        "placo_dynamics:Placo",
        "placo",
        versus="wbc-placo",
        differs="no angular momentum and no limit on a foot's yaw moment: both are left out of "
        "ours for this pair; 1e-8 on the unknowns that are left after eliminating equalities",
    ),
    Library(
        "placo-ik",
        "placo KinematicsSolver (velocities)",
        "placo_ik:PlacoIk",
        "placo",
        versus="wbc",
        torques=False,
    ),
    Library(
        "pink", "pink solve_ik (velocities)", "pink_ik:PinkIk", "pink", versus="wbc", torques=False
    ),
)
