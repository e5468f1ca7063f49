"""The one way out for text: what a stranger wrote cannot act on the terminal."""

import json
import os
import subprocess
import sys
import unicodedata

import pytest
from commands import called
from hypothesis import given
from hypothesis import strategies as st

from kneecore import ParameterSpace
from kneecore._assets import asset_path
from kneecore.cli.search import main as search
from kneecore.cli.simulate import main as simulate
from kneecore.cli.terminal import say, visible
from kneecore.cli.uncertainty import main as uncertainty

TEXT = asset_path("baseline.toml").read_text(encoding="utf-8")
HOSTILE = "\x1b]0;owned\x07\x1b[2J\x9b31m\u202eab\r\x00 [/red] [link=x]"
ALLOWED = {"\n", "\t"}


def commands_text(text):
    return [c for c in text if unicodedata.category(c) in ("Cc", "Zl", "Zp", "Cs")]


@given(st.text())
def test_what_is_visible_holds_no_control_character(text):
    shown = visible(text)
    assert set(commands_text(shown)) <= ALLOWED
    assert not any(unicodedata.bidirectional(c) in BIDI for c in shown)
    assert visible(shown) == shown
    if not commands_text(text) and not any(c in shown for c in "\\"):
        assert shown == text


BIDI = {"LRE", "RLE", "LRO", "RLO", "PDF", "LRI", "RLI", "FSI", "PDI"}


@given(st.text(st.characters(codec="utf-8")))
def test_a_document_keeps_its_meaning(text):
    assert json.loads(visible(json.dumps(text, ensure_ascii=False))) == text


@pytest.fixture
def knee(tmp_path):
    path = tmp_path / "knee.toml"
    title = json.dumps(HOSTILE)  # TOML's escapes are JSON's
    note = json.dumps("A note\x1b[8m with\x85 codes")
    text = TEXT.replace('title = "Packaged baseline"', f"title = {title}")
    start, end = text.index('note = """'), text.index("prior = ")
    path.write_text(f"{text[:start]}note = {note}\n{text[end:]}", encoding="utf-8")
    return str(path)


def check_clean(text):
    assert set(commands_text(text)) <= ALLOWED
    assert "\u202e" not in text


@pytest.mark.parametrize(
    ("main", "arguments"),
    [
        (simulate, []),
        (search, ["--quiet", "--pop-size", "20", "--generations", "5"]),
        (uncertainty, ["--quiet", "--samples", "10"]),
    ],
)
def test_a_title_with_escape_codes_is_shown(capsys, knee, main, arguments):
    code, out, err = called(capsys, main, "--baseline", knee, *arguments)
    assert code == 0
    check_clean(out + err)
    words = " ".join(out.split())
    assert "owned" in words
    assert "\\u202e" in words


def test_printed_json_is_clean_and_keeps_the_title(capsys, knee):
    code, out, _ = called(capsys, simulate, "--json", "--baseline", knee)
    assert code == 0
    check_clean(out)
    assert json.loads(out)["title"] == " ".join(HOSTILE.split())


def test_an_error_that_quotes_a_strangers_text_is_one_clean_line(capsys, tmp_path):
    path = tmp_path / "knee\x1b[2J.toml"
    path.write_text('schema = "\\u001b[2J\\u009b"', encoding="utf-8")
    code, out, err = called(capsys, simulate, "--baseline", str(path))
    assert code == 2
    assert out == ""
    check_clean(err)
    assert err.count("\n") == 1
    assert "\\x1b[2J.toml': `schema` is" in err
    code, _, err = called(capsys, simulate, "--solver", "a\x9b31m")
    assert code == 2
    check_clean(err)


def test_a_title_is_one_line():
    space = ParameterSpace(title="one\ntwo")
    assert "one two" in space.to_toml()


@pytest.mark.parametrize("module", ["simulate", "search", "uncertainty", "sweep", "paper"])
def test_help_to_a_full_disk_is_one_line(module):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", f"kneecore.{module}", "--help"],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == (
        f"python -m kneecore.{module}: stdout cannot be written (No space left on device)\n"
    )


@pytest.mark.parametrize("module", ["simulate", "search", "uncertainty", "sweep", "paper"])
def test_help_for_a_reader_that_goes(module):
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run(
        [sys.executable, "-m", f"kneecore.{module}", "--help"],
        stdout=writing,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    os.close(writing)
    assert done.returncode == 0
    assert done.stderr == ""


def test_help_is_printed_whole(capsys):
    code, out, err = called(capsys, search, "--help")
    assert code == 0
    assert err == ""
    assert out.startswith("usage: python -m kneecore.search")
    assert "--geometry-bound-mm" in out


def test_where_stderr_is_full_the_exit_code_stays():
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "kneecore.simulate", "--baseline", "none.toml"],
            stdout=subprocess.DEVNULL,
            stderr=full,
            check=False,
        )
    assert done.returncode == 2


def test_a_line_about_a_command_is_one_line(capsys):
    say("command", "one\ntwo\x1b[31m")
    assert capsys.readouterr().err == "command: one two\\u001b[31m\n"
