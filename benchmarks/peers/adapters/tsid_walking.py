"""TSID in a closed loop: the same formulation as `tsid_force`, with references that come in."""

from __future__ import annotations

import numpy as np

from peers.adapters.tsid_force import LARGEST_FORCE, Tsid, pose, sample
from peers.case import LEFT, RIGHT
from peers.reference import Reference

_SIDES = {LEFT: "left", RIGHT: "right"}
_ZERO = np.zeros(6)


class TsidWalking(Tsid):
    """Solves one tick after the other, and keeps nothing from one to the next."""

    def follow(self, reference: Reference) -> None:
        """Set state, references and standing feet of the next tick."""
        self._reference = reference
        formulation, _, com, torso, swing, contacts = self._stances[reference.stance]
        com.setReference(sample(reference.com, reference.com_velocity, reference.com_acceleration))
        rotation = np.concatenate([np.zeros(3), reference.torso_velocity])
        torso.setReference(sample(pose(np.zeros(3), reference.torso), rotation, _ZERO))
        if swing is not None:
            T = reference.swing
            swing.setReference(
                sample(
                    pose(T[:3, 3], T[:3, :3]),
                    reference.swing_velocity,
                    reference.swing_acceleration,
                )
            )
        leaving = _SIDES.get(reference.leaving)
        for side, contact in contacts.items():
            contact.setMaxNormalForce(reference.max_force if side == leaving else LARGEST_FORCE)
        self._problem = formulation.computeProblemData(0.0, reference.q, reference.v)

    def solve(self) -> tuple[bool, np.ndarray, np.ndarray]:
        """Return whether there is a solution, torques (na,) and accelerations (nv,)."""
        formulation, solver, *_ = self._stances[self._reference.stance]
        solution = solver.solve(self._problem)
        tau = np.array(formulation.getActuatorForces(solution))
        acceleration = np.array(formulation.getAccelerations(solution))
        finite = bool(np.isfinite(tau).all() and np.isfinite(acceleration).all())
        return solution.status == 0 and finite, tau, acceleration
