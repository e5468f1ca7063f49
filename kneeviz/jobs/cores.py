"""How many cores long work may take."""

from kneecore import available_cores


def spare_cores() -> int:
    """Return all cores but one, which stays free for the view; at least one."""
    return max(1, available_cores() - 1)
