"""Planners enumerate abstract plans: ``protocol`` says what one is, and each plug-in beside it is one."""

from bpns.symbolic.planners.registry import about, load, names

__all__ = ["about", "load", "names"]
