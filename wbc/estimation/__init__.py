"""State estimation: from a `Measurement` to an `Estimate` of state, contacts and foot loads.

The public names are listed in `__init__.pyi`; each loads its module when it is first used, so that
a controller that only takes estimates does not load the estimator's kernels.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
