"""What kneecore raises.

::

    KneecoreError                 everything below; catch this to catch them all
    +-- ParameterError            an argument or a parameter value is not allowed (a ValueError too)
    +-- FileFormatError           a file's content cannot be used (a ValueError too)
    +-- OutputError               a result cannot be written (an OSError too)
    +-- ModelError                the model gave no usable answer

Every message is one line that names the argument, what it got and what is allowed.
"""


class KneecoreError(Exception):
    """Base of all errors that kneecore raises on purpose."""


class ParameterError(KneecoreError, ValueError):
    """An argument or a parameter value is not allowed."""


class FileFormatError(KneecoreError, ValueError):
    """A file was read, but its content cannot be used."""


class OutputError(KneecoreError, OSError):
    """A result cannot be written where it was asked for."""


class ModelError(KneecoreError):
    """The model gave no usable answer, for instance because every sample failed."""
