"""What the pages on runs and programs show is what happens."""

import re
from pathlib import Path

import pytest

from kneecore import Input, Model, Output

DOCS = Path(__file__).resolve().parents[2] / "docs"
SAID = {
    "any_model.md": "Verdict: trusted.",
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
    names["model"].close()
    assert SAID[page] in capsys.readouterr().out
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
