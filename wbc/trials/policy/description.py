"""The description of a policy: what its network reads and writes, in a `deploy.yaml`.

The format is the one that unitree_rl_lab writes for its policies (Unitree Robotics, `deploy.yaml`
of https://github.com/unitreerobotics/unitree_rl_lab), with one key more. Numbers may be lists with
one entry per joint, or one number for all.

    step_dt: 0.02                    # s between two evaluations of the network
    joint_names: [hip, knee, …]      # motor order; by default the robot's own joints in its order
    joint_ids_map: [0, 2, …]         # network order -> index in motor order
    stiffness: [100.0, …]            # N·m/rad, motor order
    damping: [2.0, …]                # N·m·s/rad, motor order
    default_joint_pos: [-0.1, …]     # rad, network order
    commands: {base_velocity: {ranges: {lin_vel_x: [-0.5, 1], lin_vel_y: …, ang_vel_z: …}}}
    actions: {JointPositionAction: {scale: 0.25, offset: [-0.1, …], clip: null}}
    observations:                    # in the order of the network's input
      base_ang_vel: {scale: 0.2, clip: null, history_length: 5}
      …
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wbc.errors import MissingExtra, short_repr
from wbc.trials.policy.errors import PolicyError
from wbc.trials.policy.observation import ObservationTerm

_ACTION = "JointPositionAction"
_RANGES = ("lin_vel_x", "lin_vel_y", "ang_vel_z")
_NO_LIMITS = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True, eq=False)
class PolicyDescription:
    """How the network of a policy is driven. Its joints are in the network's order.

    Attributes:
        period: time between two evaluations of the network, s.
        motors: index of each joint in the motor order.
        joint_names: names of the joints in motor order; None for the robot's own.
        stiffness: (m,) N·m/rad.
        damping: (m,) N·m·s/rad.
        default: (m,) joint positions that observations are relative to, rad.
        action_scale: (m,) rad per unit of the network's output.
        action_offset: (m,) joint targets for an output of zero, rad.
        action_limits: (m, 2) smallest and largest joint target, rad.
        velocity_limits: smallest and largest forward velocity, velocity to the left, m/s, and
            turning velocity, rad/s, that the policy was trained for.
        terms: terms of the observation, in the order of the network's input.
    """

    period: float
    motors: tuple[int, ...]
    joint_names: tuple[str, ...] | None
    stiffness: np.ndarray
    damping: np.ndarray
    default: np.ndarray
    action_scale: np.ndarray
    action_offset: np.ndarray
    action_limits: np.ndarray
    velocity_limits: tuple[tuple[float, float], ...]
    terms: tuple[ObservationTerm, ...]

    @staticmethod
    def load(path: Path) -> PolicyDescription:
        """Read a description from a YAML file.

        Raises:
            PolicyError: the file cannot be read, or a key is missing or has a wrong value.
            MissingExtra: PyYAML is not installed.
        """
        try:
            text = path.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise PolicyError(f"cannot read the description '{path}': {error}") from error
        return PolicyDescription.parse(text, str(path))

    @staticmethod
    def parse(text: str, source: str = "the description") -> PolicyDescription:
        """Read a description from the text of a YAML file.

        Args:
            text: the text.
            source: name of the file, for messages.

        Raises:
            PolicyError: a key is missing or has a wrong value.
            MissingExtra: PyYAML is not installed.
        """
        try:
            return _Reader(source).description(_parse_yaml(text, source))
        except PolicyError as error:
            if source in str(error):
                raise
            raise PolicyError(f"'{source}': {error}") from error


class _Reader:
    """Reads the keys of a description, with messages that name the file and the key.

    Args:
        source: name of the file.
    """

    def __init__(self, source: str) -> None:
        self._source = source

    def description(self, tree: Any) -> PolicyDescription:
        """Return the description in a tree of YAML values."""
        ids = self._get(tree, "joint_ids_map")
        whole = isinstance(ids, list) and all(type(i) is int for i in ids)
        if not (whole and sorted(ids) == list(range(len(ids)))):
            raise self._error(
                "joint_ids_map",
                ids,
                "the index in motor order of each joint of the network, each exactly once",
            )
        size = len(ids)
        names = tree.get("joint_names")
        if names is not None and not (
            isinstance(names, list)
            and len(names) == size
            and all(isinstance(n, str) for n in names)
        ):
            raise self._error("joint_names", names, f"{size} names")
        actions = self._get(tree, "actions")
        if set(actions) != {_ACTION}:
            raise self._error("actions", actions, f"{_ACTION} and nothing else")
        action = self._get(tree, "actions", _ACTION)
        scale = self._vector(action, size, "scale")
        offset = self._vector(action, size, "offset")
        clip = action.get("clip")
        limits = np.full((size, 2), _NO_LIMITS)
        if clip is not None:
            limits = self._array(clip, "clip", (2,), (size, 2)) + np.zeros((size, 2))
        period = float(self._array(self._get(tree, "step_dt"), "step_dt", ()))
        if not period > 0.0:
            raise self._error("step_dt", period, "a positive time in s")
        observations = self._get(tree, "observations")
        if not isinstance(observations, dict) or not observations:
            raise self._error("observations", observations, "at least one term")
        return PolicyDescription(
            period,
            tuple(ids),
            None if names is None else tuple(names),
            self._vector(tree, size, "stiffness")[ids],
            self._vector(tree, size, "damping")[ids],
            self._vector(tree, size, "default_joint_pos"),
            scale,
            offset,
            limits,
            self._velocity_limits(tree),
            tuple(self._term(name, size, value) for name, value in observations.items()),
        )

    def _velocity_limits(self, tree: Any) -> tuple[tuple[float, float], ...]:
        ranges = (tree.get("commands") or {}).get("base_velocity", {}).get("ranges", {})
        limits = [_NO_LIMITS] * 3
        for i, key in enumerate(_RANGES):
            if key in ranges:
                low, high = self._array(ranges[key], key, (2,)).tolist()
                limits[i] = low, high
        return tuple(limits)

    def _term(self, name: str, joints: int, value: Any) -> ObservationTerm:
        if not isinstance(value, dict):
            raise self._error(name, value, "a table with scale, clip and history_length")
        clip, history = value.get("clip"), value.get("history_length", 1)
        if not isinstance(history, int):
            raise self._error(f"{name}: history_length", history, "a whole number")
        scale = value.get("scale")
        period = (value.get("params") or {}).get("period", 0.0)
        term = ObservationTerm(
            str(name),
            (1.0,) if scale is None else tuple(np.atleast_1d(self._number(scale, name)).tolist()),
            None if clip is None else tuple(self._array(clip, f"{name}: clip", (2,)).tolist()),
            # IsaacLab writes 0 for a term without a history.
            max(history, 1),
            float(self._array(period, f"{name}: period", ())),
        )
        if len(term.scale) not in (1, term.size(joints)):
            raise self._error(f"{name}: scale", scale, f"one number, or {term.size(joints)}")
        return term

    def _get(self, tree: Any, *keys: str) -> Any:
        for i, key in enumerate(keys):
            if not isinstance(tree, dict) or tree.get(key) is None:
                raise PolicyError(f"'{self._source}' lacks the key '{': '.join(keys[: i + 1])}'")
            tree = tree[key]
        return tree

    def _vector(self, tree: Any, size: int, key: str) -> np.ndarray:
        """Return (size,) numbers; one number stands for all."""
        return self._array(self._get(tree, key), key, (), (size,)) + np.zeros(size)

    def _number(self, value: Any, key: str) -> np.ndarray:
        """Return finite numbers of any shape."""
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            array = np.array(math.nan)
        if not np.isfinite(array).all():
            raise self._error(key, value, "finite numbers")
        return array

    def _array(self, value: Any, key: str, *shapes: tuple[int, ...]) -> np.ndarray:
        array = self._number(value, key)
        if array.shape not in shapes:
            wanted = " or ".join("one number" if s == () else f"shape {s}" for s in shapes)
            raise PolicyError(
                f"'{self._source}': '{key}' has shape {array.shape}; it must have {wanted}"
            )
        return array

    def _error(self, key: str, value: Any, wanted: str) -> PolicyError:
        return PolicyError(f"'{self._source}': '{key}' is {short_repr(value)}; it must be {wanted}")


def _parse_yaml(text: str, source: str) -> dict[str, Any]:
    """Return the tree of a YAML text; Python objects in it, which exporters write, become None.

    Raises:
        PolicyError: malformed, or no table.
        MissingExtra: PyYAML is not installed.
    """
    try:
        import yaml
    except ImportError:
        raise MissingExtra("yaml", "policy") from None
    lenient: Any = type("LenientLoader", (yaml.SafeLoader,), {})
    lenient.add_multi_constructor("", lambda loader, suffix, node: None)
    try:
        tree = yaml.load(text, Loader=lenient)
    except yaml.YAMLError as error:
        raise PolicyError(f"'{source}' is no YAML file: {error}") from error
    if not isinstance(tree, dict):
        raise PolicyError(f"'{source}' is {short_repr(tree)}; it must be a table of keys")
    return tree
