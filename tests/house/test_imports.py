"""Arrows only go down: no circle of files, no import hidden in a function, no endless module.

`lint-imports` holds the rooms in their order; here it is files, and what a linter does not see.
"""

import ast
import re

import pytest
from imports import ROOT, arrows, circles, imports_of, sources

MAX_LINES = 400
PRIVATE = re.compile(r"viser(\.\w+)*\._\w+(\.\w+)*")
DOORS = ("kneecore/presented.py", "kneecore/_command.py", "kneecore/runs/functions.py")
"""The modules that may find others by name: a result's presentation, a room's command, and a
user's function."""
VISER = ("kneeviz/viser_internals.py", "kneeviz/viser_broadcast.py")
"""The modules that alone may touch viser's private parts."""


def may_import_late(place):
    """Command lines and entry points answer `--help` before they load what they run."""
    return (
        place in DOORS
        or place.startswith("kneecore/cli/")
        or place.endswith(("/__init__.py", "/__main__.py"))
    )


def listed(offenders):
    """Each offender on a line of its own: pytest would shorten a list."""
    return "\n".join(["", *offenders])


def late_imports(root):
    found = []
    for path in sources(root):
        place = path.relative_to(root).as_posix()
        if not may_import_late(place):
            late = (one for one in imports_of(path, root) if one.in_function)
            found += [f"{place}:{one.line}: {(*one.modules, 'by name')[0]}" for one in late]
    return found


def visers_private_parts(root):
    """Imports and names in texts of what viser keeps to itself."""
    found = []
    for path in sources(root):
        place = path.relative_to(root).as_posix()
        if place in VISER:
            continue
        named = [(m, one.line) for one in imports_of(path, root) for m in one.modules[:1]]
        named += [
            (node.value, node.lineno)
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
            if isinstance(node, ast.Constant) and isinstance(node.value, str)
        ]
        found += [f"{place}:{line}: {m}" for m, line in named if PRIVATE.fullmatch(m)]
    return found


def told_circles(root):
    return [
        ", ".join(f"{start} -> {end}" for start, end in sorted(group))
        for group in circles(arrows(root))
    ]


def long_modules(root):
    counts = {
        path.relative_to(root).as_posix(): len(path.read_text(encoding="utf-8").splitlines())
        for path in sources(root, (".py", ".pyi"))
    }
    return [f"{place}: {n} lines" for place, n in counts.items() if n > MAX_LINES]


def test_no_import_is_hidden_in_a_function():
    told = late_imports(ROOT)
    assert not told, listed(told)


def test_one_module_alone_touches_visers_private_parts():
    told = visers_private_parts(ROOT)
    assert not told, listed(told)


def test_no_file_imports_itself_by_way_of_others():
    told = told_circles(ROOT)
    assert not told, listed(told)


def test_no_module_is_longer_than_can_be_read():
    told = long_modules(ROOT)
    assert not told, listed(told)


def test_something_was_looked_at():
    """Without it, an empty folder would pass all of the above."""
    assert len(sources()) > 150
    assert ("kneecore.search.worst_case", "kneecore.model") in arrows()
    assert ("kneecore", "kneecore.model") in arrows()  # by the stub


# Faults that are planted, and found.


@pytest.fixture
def house(tmp_path):
    """Return a function that writes one module of a small house."""

    def build(place, text):
        path = tmp_path / place
        path.parent.mkdir(parents=True, exist_ok=True)
        for folder in path.relative_to(tmp_path).parents[:-1]:
            (tmp_path / folder / "__init__.py").touch()
        path.write_text(text)
        return tmp_path

    return build


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("def f():\n    import json\n", "2: json"),
        ("def f():\n    from kneecore import model\n", "2: kneecore.model"),
        ("class A:\n    async def f(self):\n        if self:\n            import a.b\n", "4: a.b"),
        ("from importlib import import_module\nf = lambda: import_module('a.b')\n", "2: a.b"),
        ("import importlib\ndef f(x):\n    return importlib.import_module(x)\n", "3: by name"),
        ("def f():\n    return __import__('json')\n", "2: json"),
    ],
)
def test_an_import_in_a_function_is_found(house, text, told):
    assert late_imports(house("kneecore/files/a.py", text)) == [f"kneecore/files/a.py:{told}"]


@pytest.mark.parametrize(
    "text",
    [
        "from viser import _messages",
        "import viser._gui_handles",
        "from viser.infra._infra import WebsockServer",
        "if owner == 'viser.infra._infra':\n    pass",
    ],
)
def test_a_private_part_of_viser_is_found(house, text):
    assert len(visers_private_parts(house("kneeviz/a.py", text))) == 1
    house("kneeviz/a.py", "from viser import GuiApi\nsaid = 'viser.infra'")
    assert visers_private_parts(house(VISER[0], text)) == []


@pytest.mark.parametrize("place", ["kneecore/cli/a.py", "kneecore/a/__main__.py", *DOORS])
def test_doors_may_import_late(house, place):
    assert late_imports(house(place, "def f():\n    import json\n")) == []


def test_what_is_imported_at_the_top_is_not_late(house):
    text = "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import json\n"
    assert late_imports(house("kneeviz/a.py", text)) == []


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("import kneecore.b.two", "from kneecore.a import one"),
        ("from kneecore.b.two import g", "from kneecore.a.one import f"),
        ("from ..b import two", "from ..a.one import f"),
        (
            "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from kneecore.b import two",
            "def g():\n    from kneecore.a.one import f",
        ),
        (
            "from kneecore.b.two import g",
            "from importlib import import_module\nimport_module('kneecore.a.one')",
        ),
    ],
)
def test_a_circle_is_found_whatever_it_is_made_of(house, first, second):
    house("kneecore/a/one.py", first)
    root = house("kneecore/b/two.py", second)
    (told,) = told_circles(root)
    assert told == "kneecore.a.one -> kneecore.b.two, kneecore.b.two -> kneecore.a.one"


def test_a_circle_through_the_public_names_and_both_packages_is_found(house):
    house("kneecore/__init__.pyi", "from .a.one import f as f\n")
    house("kneecore/a/one.py", "from kneeviz.page import g\n")
    (told,) = told_circles(house("kneeviz/page.py", "from kneecore import f\n"))
    assert told.count("->") == 3


def test_arrows_that_only_go_down_are_no_circle(house):
    house("kneecore/a/one.py", "from kneecore.b import two\nfrom kneecore.b.three import h\n")
    house("kneecore/b/two.py", "from kneecore.b.three import h\n")
    root = house("kneecore/b/three.py", "import json\n")
    assert told_circles(root) == []
    assert len(arrows(root)) == 3


def test_a_long_module_is_found(house):
    house("kneeviz/short.py", "a = 1\n" * MAX_LINES)
    root = house("kneeviz/a/long.py", "a = 1\n" * (MAX_LINES + 1))
    assert long_modules(root) == [f"kneeviz/a/long.py: {MAX_LINES + 1} lines"]
