"""Whole-body kinematics and control of humanoids on Pinocchio.

`import wbc` loads only Pinocchio and numpy. A public name loads the module that defines it when it
is first used: `wbc.load` loads no controller, and only `wbc.sim` and `wbc.view` load a simulator
and a viewer. The public names are listed in `__init__.pyi`.
"""

import lazy_loader
import pinocchio  # noqa: F401 - every part needs it; loading it here makes the cost visible

__version__ = "0.1.0.dev0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
