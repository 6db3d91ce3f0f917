"""The process of one library: it waits for a case, times it and replies.

    python -m peers.worker wbc_controller:Wbc

Requests and replies are lines of JSON. A request names a case's folder, what to do ("time" or
"solve") and a file for the arrays; the reply tells the library's versions or an error.
"""

from __future__ import annotations

import os

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_name] = "1"

import importlib
import json
import sys
import traceback
from pathlib import Path

import numpy as np

from peers.case import Case
from peers.measuring import Adapter, outcomes, time_ticks


def main() -> None:
    """Reply to requests until standard input ends."""
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # keeps output of the libraries out of the replies
    module, name = sys.argv[1].split(":")
    adapters: dict[str, Adapter] = {}
    for line in sys.stdin:
        request = json.loads(line)
        try:
            folder = request["case"]
            case = Case.load(Path(folder))
            if folder not in adapters:
                make = getattr(importlib.import_module(f"peers.adapters.{module}"), name)
                adapters[folder] = make(case)
            adapter = adapters[folder]
            if request["do"] == "time":
                cpu, wall = time_ticks(adapter, len(case.ticks), request["passes"])
                np.savez(request["out"], cpu=cpu, wall=wall)
            else:
                np.savez(request["out"], **outcomes(adapter, len(case.ticks)))
            reply = {"versions": adapter.versions}
        except Exception:
            reply = {"error": traceback.format_exc(limit=4)}
        replies.write(json.dumps(reply) + "\n")


if __name__ == "__main__":
    main()
