"""A feed-forward network in an ONNX file, run on one thread."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from wbc.errors import MissingExtra
from wbc.trials.policy.errors import PolicyError


class PolicyNetwork:
    """An ONNX network with one input (1, n) and one output (1, m) of 32-bit floats.

    It keeps no state between calls. Copies share it; a pickle carries the file's contents.

    Args:
        model: contents of the ONNX file.
        source: name of the file, for messages.

    Attributes:
        source: name of the file.
        inputs: n.
        outputs: m.

    Raises:
        PolicyError: no network that can be run, or inputs and outputs of another form.
        MissingExtra: `onnxruntime` is not installed.
    """

    def __init__(self, model: bytes, source: str = "the network") -> None:
        self._model = model
        self.source = source
        self._session = _session(model, source)
        self._input, self.inputs = _vector(self._session.get_inputs(), "input", source)
        self._output, self.outputs = _vector(self._session.get_outputs(), "output", source)

    @staticmethod
    def load(path: Path) -> PolicyNetwork:
        """Read a network from an ONNX file.

        Raises:
            PolicyError: the file cannot be read, or see `PolicyNetwork`.
        """
        try:
            return PolicyNetwork(path.read_bytes(), str(path))
        except OSError as error:
            raise PolicyError(f"cannot read the network '{path}': {error}") from error

    def __repr__(self) -> str:
        return f"PolicyNetwork({self.source}, {self.inputs} inputs, {self.outputs} outputs)"

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        """Return the output (m,) for an observation (n,), both of 32-bit floats."""
        row = observation.reshape(1, -1)
        output: np.ndarray = self._session.run([self._output], {self._input: row})[0][0]
        return output

    def __deepcopy__(self, memo: dict[int, Any]) -> PolicyNetwork:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        return PolicyNetwork, (self._model, self.source)


def _session(model: bytes, source: str) -> Any:
    try:
        import onnxruntime
    except ImportError:
        raise MissingExtra("onnxruntime", "policy") from None
    options = onnxruntime.SessionOptions()
    # More threads would take the other controllers' cores, and change the order of sums.
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    try:
        return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its exceptions have no common base but this
        raise PolicyError(f"'{source}' is no ONNX network that can be run: {error}") from error


def _vector(tensors: list[Any], kind: str, source: str) -> tuple[str, int]:
    """Return name and size of the only tensor, which has the shape (1, size).

    Raises:
        PolicyError: there are more tensors, or the shape or type is another.
    """
    found = ", ".join(f"'{t.name}' {t.shape} {t.type}" for t in tensors)
    if len(tensors) == 1 and tensors[0].type == "tensor(float)":
        shape = tensors[0].shape
        # A batch size that the file leaves open is a name or None.
        if len(shape) == 2 and isinstance(shape[1], int) and shape[0] in (1, None, str(shape[0])):
            return tensors[0].name, shape[1]
    raise PolicyError(
        f"'{source}' has the {kind}s {found}; a policy needs one {kind} of shape (1, n) of "
        "32-bit floats: recurrent networks are not supported"
    )
