"""Runs of a model: here, in other processes or on a cluster; kept, timed out, counted.

It knows no model: it is handed a work (`kneecore.runs.work`) and points, and gives evaluations.
The modules in ``__init__.pyi`` are loaded when they are first used: the knee on one machine needs
none of them.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
