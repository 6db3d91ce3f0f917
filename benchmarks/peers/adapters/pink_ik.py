"""Adapter of pink's `solve_ik`, which solves a smaller problem: velocities only."""

from __future__ import annotations

from importlib.metadata import version

import numpy as np
import pinocchio as pin
from pink import Configuration, solve_ik
from pink.tasks import ComTask, FrameTask, PostureTask

from peers.case import LEFT, RIGHT, SOLES, STANCES, TORSO, Case
from peers.measuring import Outcome

DT = 0.002
SOLVER = "daqp"  # the fastest of daqp, quadprog and proxqp here


class PinkIk:
    """Uses constraints for the standing feet, tasks for CoM, torso, swing foot and posture."""

    def __init__(self, case: Case) -> None:
        names = ("pin-pink", "pin", "qpsolvers", "daqp")
        self.versions = {name: version(name) for name in names}
        ticks, gains = case.ticks, case.gains
        self._model = model = pin.buildModelFromXML(case.urdf, pin.JointModelFreeFlyer())
        model.armature = np.concatenate([np.zeros(6), case.armature])
        data = model.createData()
        M = pin.crba(model, data, ticks.q[0])
        M = np.triu(M) + np.triu(M, 1).T
        h = pin.nonLinearEffects(model, data, ticks.q[0], ticks.v[0])
        case.check_model(M, h, list(model.names)[2:])
        self._configuration = Configuration(model, data, ticks.q[0])
        root = np.sqrt
        com = ComTask(cost=root(gains.com_weight))
        torso = FrameTask(TORSO, position_cost=0.0, orientation_cost=root(gains.torso_weight))
        posture = PostureTask(cost=root(gains.posture_weight))
        posture.set_target(np.concatenate([ticks.q[0, :7], ticks.posture]))
        self._stances = {}
        for stance in np.unique(ticks.stance):
            feet = [
                FrameTask(SOLES[side], position_cost=1.0, orientation_cost=1.0)
                for side in STANCES[stance]
            ]
            tasks, swing = [com, torso, posture], None
            if stance in (LEFT, RIGHT):
                free = SOLES["right" if stance == LEFT else "left"]
                cost = root(gains.swing_weight)
                swing = FrameTask(free, position_cost=cost, orientation_cost=cost)
                tasks.append(swing)
            self._stances[stance] = (tasks, feet, com, torso, swing)
        self._per_tick = [self._stances[s] for s in ticks.stance]
        self._q, self._com = list(ticks.q), list(ticks.com)
        self._torso = [pin.SE3(R, np.zeros(3)) for R in ticks.torso]
        self._feet = [self._placements(q, s) for q, s in zip(ticks.q, ticks.stance, strict=True)]
        self._swing = [pin.SE3(T[:3, :3], T[:3, 3]) for T in ticks.swing]

    def _placements(self, q: np.ndarray, stance: int) -> list[pin.SE3]:
        """Return the placements at which the standing feet are held."""
        self._configuration.update(q)
        sides = STANCES[stance]
        return [self._configuration.get_transform_frame_to_world(SOLES[side]) for side in sides]

    def tick(self, k: int) -> np.ndarray:
        """See `Adapter`; a velocity instead of torques."""
        tasks, feet, com, torso, swing = self._per_tick[k]
        configuration = self._configuration
        configuration.update(self._q[k])
        for foot, placement in zip(feet, self._feet[k], strict=True):
            foot.set_target(placement)
        com.set_target(self._com[k])
        torso.set_target(self._torso[k])
        if swing is not None:
            swing.set_target(self._swing[k])
        self._velocity = solve_ik(
            configuration, tasks, DT, solver=SOLVER, constraints=feet, safety_break=False
        )
        return self._velocity

    def outcome(self) -> Outcome:
        """See `Adapter`; there are no torques."""
        nv = self._model.nv
        ok = bool(np.isfinite(self._velocity).all())
        return Outcome(ok, np.full(nv - 6, np.nan), np.full(nv, np.nan), np.full((2, 6), np.nan))
