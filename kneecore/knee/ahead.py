"""What another process compiles of the knee at the first start, by name: no numba is loaded.

It gains time where there is something else to do until the first knee is wanted: an import, say.
"""

from kneecore._second_compiler import compile_apart

__all__ = ["AT_REST", "IN_MOTION", "compile_ahead"]

IN_MOTION = "kneecore.knee.trajectory:compile_motion"
AT_REST = "kneecore.knee.model:compile_at_rest"


def compile_ahead() -> None:
    """Have the knee's motion compiled if nothing is yet; return at once."""
    compile_apart(IN_MOTION)
