"""Learned policies as controllers: an ONNX network and the description of how to drive it."""

from wbc.trials.policy.controller import PolicyController, load_policy, policy_files
from wbc.trials.policy.description import PolicyDescription
from wbc.trials.policy.errors import PolicyError
from wbc.trials.policy.network import PolicyNetwork
from wbc.trials.policy.observation import ObservationTerm

__all__ = [
    "ObservationTerm",
    "PolicyController",
    "PolicyDescription",
    "PolicyError",
    "PolicyNetwork",
    "load_policy",
    "policy_files",
]
