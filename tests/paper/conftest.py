"""What the tests of the redone paper share."""

import pytest

from kneecore import redo_paper


@pytest.fixture(scope="session")
def report():
    """Return the paper redone with small budgets."""
    return redo_paper(quick=True)
