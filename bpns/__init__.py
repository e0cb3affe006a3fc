"""Bilevel planning with neuro-symbolic skills: learn operators, policies and samplers; plan with PDDL.

Everything public is a name of this package; what it is and where it is from stands in ``__init__.pyi``. It is
imported when it is first used, so that ``import bpns`` is fast, and PyTorch when something is learned. All
else in the packages below is internal.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
