"""What is found by its name is there: commands above their rooms, words and files above results."""

import subprocess
import sys
from importlib import import_module

import pytest

from kneecore.presented import _FILES_OF_SEVERAL, _PLACES, Format, Words


@pytest.mark.parametrize("name", ["search", "simulate", "uncertainty", "sweep", "paper"])
def test_a_command_is_found_by_its_name(name):
    command = [sys.executable, "-m", f"kneecore.{name}", "--help"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0
    assert done.stdout.startswith(f"usage: python -m kneecore.{name} ")
    assert done.stderr == ""


@pytest.mark.parametrize("result", _PLACES)
def test_a_result_has_words_files_and_figures(result):
    report, files, figures = _PLACES[result]
    assert isinstance(import_module(f"kneecore.{report}").WORDS, Words)
    assert isinstance(import_module(f"kneecore.{files}").FORMAT, Format)
    assert not figures or callable(import_module(f"kneecore.{figures}").draw)


def test_no_two_results_call_themselves_the_same():
    rooms = [*(files for _, files, _ in _PLACES.values()), *_FILES_OF_SEVERAL]
    schemas = [import_module(f"kneecore.{files}").FORMAT.schema for files in rooms]
    assert len(set(schemas)) == len(schemas)


SEARCH = """
from kneecore import Knee, SearchSettings, worst_case
found = worst_case(Knee(), SearchSettings(pop_size=20, n_generations=5))
str(found), found.to_json()
"""


@pytest.mark.parametrize(
    ("code", "rare"),
    [
        (SEARCH, ("scipy.stats", "matplotlib", "cloudpickle", "distributed", "multiprocessing")),
        ("import kneeviz.server.app", ("scipy.stats", "matplotlib", "cloudpickle", "distributed")),
    ],
    ids=["search", "page"],
)
def test_a_start_loads_no_more_than_it_needs(code, rare):
    """Every tenth of a second counts at the start; what is rare is loaded when it is used."""
    code += f"\nimport sys\nprint([name for name in {rare} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
