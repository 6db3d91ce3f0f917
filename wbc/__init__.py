"""Whole-body kinematics and control of humanoids on Pinocchio.

`import wbc` loads no other package. A public name loads the module that defines it when it is first
used: `wbc.load` loads Pinocchio and numpy but no controller, and only `wbc.sim` and `wbc.view` load
a simulator and a viewer. The public names are listed in `__init__.pyi`.
"""

import lazy_loader

__version__ = "0.1.0.dev0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
