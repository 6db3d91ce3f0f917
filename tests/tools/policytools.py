"""Helpers for the tests of learned policies: a small network and its description."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import wbc
from wbc.trials.policy import PolicyNetwork


def linear_network(weights: np.ndarray, offset: np.ndarray | None = None) -> bytes:
    """Return an ONNX file of the network y = x W + b.

    Args:
        weights: (n, m) W.
        offset: (m,) b; zero when left out.
    """
    onnx = pytest.importorskip("onnx")
    inputs, outputs = weights.shape
    offset = np.zeros(outputs) if offset is None else offset
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    graph = helper.make_graph(
        [helper.make_node("Gemm", ["obs", "W", "b"], ["actions"])],
        "linear",
        [helper.make_tensor_value_info("obs", kind, [1, inputs])],
        [helper.make_tensor_value_info("actions", kind, [1, outputs])],
        [
            onnx.numpy_helper.from_array(weights.astype(np.float32), "W"),
            onnx.numpy_helper.from_array(offset.astype(np.float32), "b"),
        ],
    )
    opset = [helper.make_opsetid("", 17)]
    return helper.make_model(graph, opset_imports=opset, ir_version=9).SerializeToString()


def load_network(weights: np.ndarray, offset: np.ndarray | None = None) -> PolicyNetwork:
    """Return a `PolicyNetwork` of y = x W + b."""
    pytest.importorskip("onnxruntime")
    return PolicyNetwork(linear_network(weights, offset), "linear.onnx")


def write_standing_policy(folder: Path, robot: wbc.Robot) -> None:
    """Write a policy that always asks for the robot's nominal posture."""
    posture, n = robot.q_nominal[7:].tolist(), robot.na
    (folder / "deploy.yaml").write_text(
        f"step_dt: 0.02\njoint_ids_map: {list(range(n))}\nstiffness: 200.0\ndamping: 5.0\n"
        f"default_joint_pos: {posture}\nobservations: {{projected_gravity: {{scale: 1.0}}}}\n"
        f"actions: {{JointPositionAction: {{scale: 0.25, offset: {posture}}}}}\n"
    )
    (folder / "policy.onnx").write_bytes(linear_network(np.zeros((3, n))))
