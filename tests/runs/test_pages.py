"""What the pages on runs and programs show is what happens."""

import re
from pathlib import Path

import numpy as np
import pytest

from kneecore import Input, Model, Output

DOCS = Path(__file__).resolve().parents[2] / "docs"
SAID = {
    "any_model.md": "Verdict: trusted.",
    "inputs.md": "1 truncated normal with bounds at 3 sd, 1 log-normal",
    "cluster.md": "run 2 raised RuntimeError: no convergence",
    "programs.md": "model 1 gives 0.136364 mm, model 2 0.166667 mm",
}
"""What each page's examples print, among other things."""


def blocks(page, language):
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)


@pytest.mark.parametrize("page", SAID)
def test_the_examples_run(page, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {"__name__": page}
    shown = blocks(page, "python")
    assert shown
    for block in shown:
        exec(compile(block, page, "exec"), names)
    assert SAID[page] in capsys.readouterr().out
    if page == "inputs.md":
        [text] = blocks(page, "toml")
        text += '[[outputs]]\nname = "y"\n[function]\nrun = "math:hypot"\n'
        (tmp_path / "filter.toml").write_text(text)
        model, shown = Model.from_file("filter.toml"), names["filter_"]
        for one, other in zip(model.inputs, shown.inputs, strict=True):
            assert (one.drawn, one.allowed) == (other.drawn, other.allowed)
        np.testing.assert_array_equal(model.correlation, shown.correlation)
        return
    names["model"].close()
    if page == "programs.md":
        [text] = blocks(page, "toml")
        (tmp_path / "springs.toml").write_text(text)
        model = Model.from_file("springs.toml")
        assert model.evaluate([[100.0, 50.0]]).tolist() == [[0.03, 0.06, 0.15]]
        model.close()


def test_every_option_of_runs_is_explained():
    text = (DOCS / "cluster.md").read_text(encoding="utf-8")
    for option in vars(Model(None, *_made())._options):
        assert option in text


def _made():
    return [Input("a", lower=0.0, upper=1.0)], [Output("y")]
