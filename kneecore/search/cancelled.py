"""The way out of a search that was cancelled before there was anything to show."""


class Cancelled(Exception):
    """The callback asked to stop before the search had a first pair. No error."""
