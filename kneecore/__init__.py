"""kneecore: the worst case of a model, and a 2D dynamic knee as the model it was made for.

The public names are in ``__init__.pyi``, once; each is loaded when it is first used, so that
``import kneecore`` and ``--help`` stay fast.

Examples
--------
>>> import kneecore
>>> result = kneecore.worst_case(kneecore.Knee(), kneecore.SearchSettings(seed=1))
>>> bool(result.objective_model > 100)  # deg, summed over the 12 loads
True
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
