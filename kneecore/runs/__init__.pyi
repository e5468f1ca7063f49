"""What is loaded late, by models that are run through it."""

from . import engine as engine
from . import identity as identity
from . import work as work
