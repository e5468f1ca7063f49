"""What is loaded late, by models that are run through it."""

from . import engine as engine
from . import identity as identity
from . import model_file as model_file
from . import program as program
from . import work as work
