"""Viewers: a live page in the browser, recordings that play offline, replays and videos.

The public names are listed in `__init__.pyi`; each loads its module when it is first used. The
process of the control loop loads neither meshcat, nor a web server, nor meshes.
"""

import lazy_loader

from wbc.runtime.snapshot import Snapshot as Snapshot

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
__all__ += ["Snapshot"]
