"""The examples in the docstrings and in the README do what they say."""

import doctest
import importlib
import pkgutil
import re
from pathlib import Path

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


README = Path(__file__).resolve().parents[2] / "README.md"


def python_blocks(markdown):
    """Yield each Python block, moved to its own lines so that a traceback names the README's."""
    for found in re.finditer(r"^```python\n(.*?)^```$", markdown, re.MULTILINE | re.DOTALL):
        yield "\n" * markdown.count("\n", 0, found.start(1)) + found[1]


def test_the_readmes_examples_run_one_after_the_other(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    blocks = list(python_blocks(README.read_text(encoding="utf-8")))
    assert blocks
    names = {"__name__": "readme"}
    for block in blocks:
        exec(compile(block, str(README), "exec"), names)


def test_a_block_is_found_at_its_line():
    markdown = "text\n```sh\nls\n```\n```python\na = 1\n\nb = a / 0\n```\n```python\nc = 2\n```\n"
    first, second = python_blocks(markdown)
    assert (first.lstrip("\n"), second.lstrip("\n")) == ("a = 1\n\nb = a / 0\n", "c = 2\n")
    with pytest.raises(ZeroDivisionError) as error:
        exec(compile(first, "README.md", "exec"), {})
    assert error.traceback[-1].lineno + 1 == markdown.split("\n").index("b = a / 0") + 1
