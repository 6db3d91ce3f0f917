"""The process of a library in a closed loop: one request and one reply per tick, as raw numbers.

    python -m peers.stream_worker tsid_walking:TsidWalking CASE_FOLDER

A request is `Reference.pack`ed, a reply `[solved, torques, accelerations]`; both are 64-bit floats.
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import importlib
import sys
from pathlib import Path

import numpy as np

from peers.case import Case
from peers.reference import Reference


def main() -> None:
    """Reply to requests until standard input ends."""
    requests, replies = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb", buffering=0)
    os.dup2(2, 1)  # keeps output of the library out of the replies
    module, name = sys.argv[1].split(":")
    case = Case.load(Path(sys.argv[2]))
    adapter = getattr(importlib.import_module(f"peers.adapters.{module}"), name)(case)
    nv = len(case.joints) + 6
    size = 8 * Reference.size(nv)
    replies.write(np.zeros(1 + nv - 6 + nv).tobytes())  # ready
    while len(request := requests.read(size)) == size:
        adapter.follow(Reference.unpack(np.frombuffer(request), nv))
        solved, tau, acceleration = adapter.solve()
        replies.write(np.concatenate(([float(solved)], tau, acceleration)).tobytes())


if __name__ == "__main__":
    main()
