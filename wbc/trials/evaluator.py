"""Compares a controller's reference with the true state: for reports, never for control."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pinocchio as pin

from wbc.motions import MotionPlayer, MotionReference
from wbc.robot import Robot
from wbc.runtime.protocols import Controller, Plant
from wbc.runtime.report import Report
from wbc.runtime.tick import Tick
from wbc.state import State
from wbc.trials.flight import FlightDetector

_REACHED = 0.01  # m; a target counts as reached within this distance
_LOADED = 0.05  # smallest commanded load of a sole in contact, as a share of the weight


class RunEvaluator:
    """An observer that compares a run with the true state; `amend` adds the results to the report.

    CoM and targets are compared relative to the true soles and their heading. Horizontal drift of
    the estimate therefore does not count as an error; tilt and height do.
    """

    def begin(self, controller: Controller, plant: Plant) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        self._robot: Robot = plant.robot
        self._data = plant.robot.model.createData()
        self._player = controller if isinstance(controller, MotionPlayer) else None
        self._flights = FlightDetector(plant.robot)
        self._square_sum, self._ticks = 0.0, 0
        self._slip = 0.0
        self._anchors: dict[str, np.ndarray] = {}
        self._errors: dict[tuple[str, int], float] = {}

    def observe(self, tick: Tick) -> None:
        """See `wbc.runtime.protocols.Observer`."""
        if tick.truth is None:
            return
        self._flights.record(tick)
        self._update_kinematics(tick.truth)
        for sole in self._robot.soles:
            wrench = tick.command.wrenches.get(sole.name)
            if wrench is None or wrench[2] < _LOADED * self._robot.weight:
                self._anchors.pop(sole.name, None)
                continue
            position = self._position(sole.frame_id)[:2]
            anchor = self._anchors.setdefault(sole.name, position)
            self._slip = max(self._slip, math.hypot(*(position - anchor)))
        if self._player is not None:
            self._compare(self._player.reference)

    def end(self, report: Report) -> None:
        """See `wbc.runtime.protocols.Observer`."""

    def amend(self, report: Report) -> Report:
        """Return the report with CoM error, foot slip, targets, notes and flights added."""
        errors = [1e3 * e for e in self._errors.values()]
        rms = 1e3 * math.sqrt(self._square_sum / self._ticks) if self._ticks else None
        player = self._player
        return replace(
            report,
            com_error_rms_mm=rms,
            foot_slip_mm=1e3 * self._slip,
            targets=len(errors),
            targets_reached=sum(e <= 1e3 * _REACHED for e in errors),
            target_error_max_mm=max(errors) if errors else None,
            notes=() if player is None else tuple(player.context.notes),
            aborted_motions=() if player is None else player.aborted_motions,
            flights=self._flights.flights,
        )

    def _compare(self, reference: MotionReference) -> None:
        left, right = (self._position(sole.frame_id) for sole in self._robot.soles)
        heading = self._heading()
        if reference.com is not None:
            origin = right + reference.weight_shift * (left - right)
            error = heading.T @ (self._data.com[0] - origin) - reference.com
            self._square_sum += float(error @ error)
            self._ticks += 1
        for target in reference.targets:  # the error at the last tick of each target counts
            place = self._position(self._robot.frame_id(target.frame))
            position = heading.T @ (place - 0.5 * (left + right))
            error = float(np.linalg.norm(position - target.place))
            self._errors[target.frame, target.number] = error

    def _update_kinematics(self, truth: State) -> None:
        model, data = self._robot.model, self._data
        pin.centerOfMass(model, data, truth.q)  # also the forward kinematics

    def _placement(self, frame_id: int) -> pin.SE3:
        return pin.updateFramePlacement(self._robot.model, self._data, frame_id)

    def _position(self, frame_id: int) -> np.ndarray:
        return np.array(self._placement(frame_id).translation)

    def _heading(self) -> np.ndarray:
        axes = [self._placement(sole.frame_id).rotation[:2, 0] for sole in self._robot.soles]
        x, y = axes[0] + axes[1]
        angle = math.atan2(y, x)
        c, s = math.cos(angle), math.sin(angle)
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
