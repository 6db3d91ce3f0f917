"""The controllers under test: the walker with options, or a factory of one's own."""

from __future__ import annotations

import contextlib
import functools
import importlib
import importlib.util
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

from wbc.errors import WbcError, did_you_mean
from wbc.gait import GaitParameters
from wbc.robot import Robot
from wbc.runtime.protocols import ControllerFactory
from wbc.trials.digest import path_digest
from wbc.trials.errors import TrialError
from wbc.trials.policy import PolicyError, load_policy, policy_files
from wbc.walking import Walker
from wbc.walking.gains import WalkerGains


@dataclass(frozen=True)
class ControllerSpec:
    """A controller under test, as a grid declares it.

    Attributes:
        name: its name in results; by default its factory.
        factory: `"walker"`, `"policy"`, or `"module:name"` of a `ControllerFactory`, which is
            imported where the trial runs.
        options: further keyword arguments of the factory; those of the walker are the ones of
            `make_walker`, those of a policy the ones of `wbc.trials.policy.load_policy`.
    """

    name: str = ""
    factory: str = "walker"
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.name:
            object.__setattr__(self, "name", self.factory)

    @classmethod
    def of_policy(cls, folder: Path) -> ControllerSpec:
        """Return the controller of the learned policy in a folder, see `load_policy`."""
        return cls("policy", "policy", {"folder": str(folder.expanduser().resolve())})

    def content(self) -> dict[str, Any]:
        """Return all that decides how it behaves: the name left out, files by their content."""
        module, colon, _ = self.factory.partition(":")
        options = dict(self.options)
        if self.factory == "policy" and "folder" in options:
            # Only its files: results may be written to the same folder. They may also be read where
            # the policy is not.
            with contextlib.suppress(PolicyError):
                options["folder"] = [
                    str(path.resolve()) for path in policy_files(options["folder"])
                ]
        return {
            "factory": self.factory,
            "source": _source_digest(module) if colon else "",
            "options": _without_paths(options),
        }

    def resolve(self) -> ControllerFactory:
        """Return the factory, with its options bound.

        Raises:
            TrialError: there is no such factory.
        """
        if self.factory == "walker":
            return partial(make_walker, **self.options)
        if self.factory == "policy":
            if "folder" not in self.options:
                raise TrialError(
                    f"controller '{self.name}' is a policy without a folder: give it "
                    "options = { folder = … }"
                )
            return partial(load_policy, **self.options)
        module, colon, name = self.factory.partition(":")
        if not (module and colon and name):
            raise TrialError(
                f"controller factory '{self.factory}' must be 'walker', 'policy' or of the form "
                "'module:name', e.g. 'my_package.controllers:make_controller'"
            )
        try:
            found: Any = importlib.import_module(module)
        except ImportError as error:
            raise TrialError(
                f"controller factory '{self.factory}': cannot import '{module}' ({error}); its "
                "folder must be in PYTHONPATH, on every worker"
            ) from error
        for part in name.split("."):
            if not hasattr(found, part):
                near = did_you_mean(part, [n for n in vars(found) if not n.startswith("_")])
                raise TrialError(
                    f"controller factory '{self.factory}': '{module}' has no '{name}'{near}"
                )
            found = getattr(found, part)
        factory: ControllerFactory = partial(found, **self.options)
        return factory


@functools.lru_cache
def _source_digest(module: str) -> str:
    """Return a digest of a module's file; an empty text if it has none."""
    found = sys.modules.get(module)
    try:
        spec = None if found is not None else importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return ""
    path = getattr(found, "__file__", None) or (spec.origin if spec is not None else None)
    return path_digest(path) if path is not None and Path(path).is_file() else ""


def _without_paths(value: Any) -> Any:
    """Return options with the digest of what is there in place of each existing path."""
    if isinstance(value, Mapping):
        return {key: _without_paths(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_without_paths(one) for one in value]
    if isinstance(value, str) and "/" in value and Path(value).exists():
        return path_digest(value)
    return value


def make_walker(
    robot: Robot,
    dt: float,
    *,
    gait: Mapping[str, float] | None = None,
    gains: Mapping[str, float] | None = None,
    recovery: bool = True,
    recovery_gait: Mapping[str, float] | None = None,
    planner: str | None = None,
    solver: str | None = None,
) -> Walker:
    """Return a walker with some parameters changed.

    Args:
        robot: the robot.
        dt: control period, s.
        gait: values of `GaitParameters` in place of those scaled to the robot.
        gains: values of `WalkerGains` in place of the defaults.
        recovery: whether quick steps catch a push.
        recovery_gait: values of `GaitParameters` in place of those of `for_recovery`.
        planner: name of the planner.
        solver: name of the QP solver.

    Raises:
        TrialError: a parameter that does not exist, or that its class refuses.
    """
    normal = _changed(GaitParameters.for_robot(robot), gait, "gait")
    quick = GaitParameters.for_recovery(robot, normal) if recovery else normal
    return Walker(
        robot,
        dt,
        gait=normal,
        recovery_gait=_changed(quick, recovery_gait, "recovery_gait"),
        gains=_changed(WalkerGains.for_robot(robot), gains, "gains"),
        planner=planner,
        solver=solver,
    )


def _changed(parameters: Any, values: Mapping[str, float] | None, option: str) -> Any:
    """Return a dataclass with some values changed; itself without any."""
    if not values:
        return parameters  # the walker knows by identity that the gait itself is the recovery's
    known = parameters.__dataclass_fields__
    for name in values:
        if name not in known:
            raise TrialError(f"walker option {option} has no '{name}'{did_you_mean(name, known)}")
    try:
        return replace(parameters, **values)
    except (WbcError, TypeError) as error:
        raise TrialError(f"walker option {option}: {error}") from error
