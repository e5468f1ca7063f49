"""What several tests of runs share."""

import runpy

import pytest


@pytest.fixture
def run_study(monkeypatch, capsys):
    """Return a function that runs ``study.py`` of a folder and returns what it prints."""

    def run(folder):
        monkeypatch.chdir(folder)
        monkeypatch.syspath_prepend(folder)
        capsys.readouterr()
        runpy.run_path(str(folder / "study.py"), run_name="__main__")
        return capsys.readouterr().out

    return run
