"""The command that searches a model of one's own again, as a page shows it."""

import shlex
from dataclasses import replace

import models
import pytest

from kneecore import Model, SearchSettings
from kneecore.cli import run
from kneecore.cli.flags import settings_from
from kneecore.cli.search import COMMAND, Options
from kneecore.report.model_command import model_command
from kneecore.search.worst_case import usual_settings

FILE = """
inputs = [{ name = "a", lower = 0.0, upper = 1.0 }, { name = "b", lower = 0.0, upper = 1.0 }]
outputs = [{ name = "y" }]
function = { run = "operator:itemgetter" }
"""


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "a model.toml"
    path.write_text(FILE)
    return Model.from_file(path)


@pytest.mark.parametrize("seed", [0, 7])
def test_it_means_the_same_search_of_the_same_file(model, seed):
    settings = replace(usual_settings(model), seed=seed).of(model)
    command = model_command(model.with_runs(workers=1), settings)
    assert command.startswith(COMMAND)
    words = shlex.split(command)[len(COMMAND.split()) :]
    options = run.parse(Options, words, COMMAND)
    assert options.model == model.file
    assert settings_from(SearchSettings, options).of(model) == settings


def test_a_model_that_was_not_read_has_none():
    model = models.two_units()
    assert model_command(model, usual_settings(model)) is None
