"""The examples in the docstrings do what they say."""

import doctest
import importlib
import pkgutil

import pytest

import kneecore

MODULES = [
    info.name
    for info in pkgutil.walk_packages(kneecore.__path__, "kneecore.")
    if not info.name.endswith(
        (
            "__main__",
            "kneecore.simulate",
            "kneecore.uncertainty",
            "kneecore.sweep",
        )
    )
]


@pytest.mark.parametrize("name", ["kneecore", *MODULES])
def test_examples(name):
    results = doctest.testmod(importlib.import_module(name), optionflags=doctest.ELLIPSIS)
    assert results.failed == 0


def test_there_are_examples_where_people_begin():
    for name in ("kneecore", "kneecore.knee.space", "kneecore.knee.response"):
        finder = doctest.DocTestFinder()
        assert any(t.examples for t in finder.find(importlib.import_module(name))), name
