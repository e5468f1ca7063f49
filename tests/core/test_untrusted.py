"""Files from strangers: refused before a parser sees them, read only where they are files."""

import json
import os
import socket
import string
import threading
import tomllib

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from kneecore import FileFormatError, KneecoreError, packaged_knee, read_knee
from kneecore import _untrusted as untrusted
from kneecore._assets import asset_path
from kneecore.knee.file import MAX_BYTES, parse_knee

TEXT = asset_path("baseline.toml").read_text(encoding="utf-8")
LINES = TEXT.splitlines()


@pytest.fixture
def no_parser(monkeypatch):
    """Make both parsers fail the test: what is hostile must never reach them."""

    def reached(*_, **__):
        pytest.fail("the parser was reached")

    monkeypatch.setattr(untrusted.tomllib, "loads", reached)
    monkeypatch.setattr(untrusted.json, "loads", reached)


HOSTILE_TOML = {
    "a key of 20,000 parts": ("a" + ".a" * 19_999 + " = 1", "20,000 dotted parts"),
    "with spaces and quotes": ("a" + " . 'a' . \"a\"" * 900 + " = 1", "1,801 dotted parts"),
    "in a table's name": ("[a" + ".a" * 9_000 + "]", "9,001 dotted parts"),
    "behind a text": ("x = '''\n'''\n" + "a" + ".a" * 20 + " = 1", "21 dotted parts"),
    "behind escaped quotes": ('x = "\\""\na' + ".a" * 20 + " = 1", "21 dotted parts"),
    "behind five quotes": ('x = """a"""""\na' + ".a" * 20 + " = 1", "21 dotted parts"),
    "behind a comment with a quote": ("# don't\na" + ".a" * 20 + " = 1", "21 dotted parts"),
    "in an inline table": ("x = {" + "a" + ".a" * 20 + " = 1}", "21 dotted parts"),
    "brackets": ("x = " + "[" * 5_000, "nested 5,000 deep"),
    "closed brackets": ("x = " + "[" * 33 + "]" * 33, "nested 33 deep"),
    "inline tables": ("x = " + "{a=" * 5_000, "nested 5,000 deep"),
    "a long line": ("x = '" + "x" * 60_000 + "'", "a line has 60,006 characters"),
    "many keys": ("\n".join(f"a{i} = 1" for i in range(10_001)), "10,001 keys, values"),
    "many tables": ("[[a]]\n" * 2_501, "10,004 keys, values"),
    "larger than 1 MB": ("#\n" * 500_001, "larger than 1,000,000 bytes"),
    "larger in UTF-8": ("# \N{SNOWMAN}\n" * 200_000, "larger than 1,000,000 bytes"),
}


@pytest.mark.parametrize("kind", HOSTILE_TOML)
def test_hostile_toml_never_reaches_the_parser(no_parser, kind, tmp_path):
    text, said = HOSTILE_TOML[kind]
    with pytest.raises(FileFormatError, match=said):
        parse_knee(text)
    path = tmp_path / "knee.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(FileFormatError, match=said):
        read_knee(path)


@pytest.mark.parametrize(
    "harmless",
    [
        "# a.b.c.d.e.f.g.h.i.j.k.l and [[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[\n",
        'x = "a.b.c.d.e.f.g.h.i.j.k.l"\n',
        "x = 'a.b.c.d.e.f.g.h.i.j.k.l'\n",
        'x = """\n' + "[" * 50 + '\n\\"""' + ".a" * 20 + '"""\n',
        "x = '''\n" + "[" * 50 + "''" + ".a" * 20 + "'''\n",
        "x = [" + ", ".join(["1.5"] * 50) + "]\n",
        '[a.b]\nc.d = {e.f = 1, g."h.i" = 2.5}\n',
    ],
)
def test_what_only_looks_deep_is_parsed(harmless):
    assert untrusted.parse_toml(harmless, MAX_BYTES) == tomllib.loads(harmless)


TOML_PIECES = st.sampled_from(
    ["a", "b", ".", " ", "\n", "=", "1", "1.5", ",", "[", "]", "{", "}", '"', "'", "\\", "#"]
    + ['"""', "'''", '"x"', "'y'", "\r\n", "x = ", "\n[t.u]\n", 'k = "a.b"\n']
)


@settings(max_examples=400, deadline=None)
@given(st.lists(TOML_PIECES, max_size=60).map("".join))
@example('a = """"""\na.b.c.d.e.f.g.h.i = 1')
@example("a = ''''''\na.b.c.d.e.f.g.h.i = 1")
def test_what_is_valid_and_shallow_is_read_and_what_is_deep_is_not(text):
    value, refused = outcome(untrusted.parse_toml, text, MAX_BYTES)
    try:
        expected = tomllib.loads(text)
    except ValueError:
        assert refused
        return
    if deepest_table(expected) <= untrusted.DEEPEST_KEY:
        assert value == expected
    else:
        assert refused is None or "dotted parts" in refused


def outcome(function, *arguments):
    """Return what the function returns, or None and the message with which it refuses."""
    try:
        return function(*arguments), None
    except KneecoreError as error:
        return None, str(error)


def deepest_table(value):
    if isinstance(value, dict):
        return 1 + max(map(deepest_table, value.values()), default=0)
    if isinstance(value, list):
        return max(map(deepest_table, value), default=0)
    return 0


@settings(max_examples=300, deadline=None)
@given(
    st.lists(
        st.tuples(
            st.integers(0, len(TEXT) - 1),
            st.sampled_from(["cut", "insert", "repeat", "line"]),
            st.text(max_size=20) | TOML_PIECES | st.sampled_from(["1e999", "nan", "1" * 400]),
        ),
        min_size=1,
        max_size=6,
    )
)
def test_a_mutated_knee_is_read_or_refused_in_one_line(changes):
    text = TEXT
    for place, kind, piece in changes:
        if kind == "cut":
            text = text[:place] + text[place + len(piece) + 1 :]
        elif kind == "insert":
            text = text[:place] + piece + text[place:]
        elif kind == "repeat":
            text = text[:place] + text[max(0, place - 200) :]
        else:
            lines = text.splitlines()
            lines.insert(place % (len(lines) + 1), piece)
            text = "\n".join(lines)
    knee, refused = outcome(parse_knee, text)
    if knee is None:
        assert "\n" not in refused
        assert len(refused) < 500
    else:
        assert np.isfinite(knee.baseline).all()
        assert np.isfinite(knee.half_ranges).all()
        assert "\n" not in knee.title


@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=200))
def test_any_bytes_are_a_knee_or_refused_in_one_line(content):
    with pytest.raises(FileFormatError) as caught:
        parse_knee(content)
    assert "\n" not in str(caught.value)


def test_a_byte_order_mark_is_no_part_of_the_text(tmp_path):
    path = tmp_path / "knee.toml"
    path.write_text(TEXT, encoding="utf-8-sig")
    assert read_knee(path).title == packaged_knee().title
    assert parse_knee(path.read_bytes()).title == packaged_knee().title
    assert untrusted.parse_json("\ufeff[1]", 100) == [1]
    assert untrusted.decoded(b"\xef\xbb\xbfa") == "a"


class TestOnlyRegularFiles:
    def refused(self, path):
        """Read in a thread that is given up: an unguarded read of a pipe never ends."""
        said = []

        def read():
            try:
                read_knee(path)
            except FileFormatError as error:
                said.append(str(error))

        reader = threading.Thread(target=read, daemon=True)
        reader.start()
        reader.join(10.0)
        assert said, "the reader waits"
        assert str(path) in said[0] or repr(path) in said[0]
        assert "\n" not in said[0]
        return said[0]

    def test_a_pipe(self, tmp_path):
        os.mkfifo(tmp_path / "pipe")
        assert "a device, a pipe or a socket" in self.refused(tmp_path / "pipe")

    def test_a_pipe_that_takes_the_files_place_meanwhile(self, tmp_path, monkeypatch):
        """Only the second look, at what was opened, can see it; opening must not wait."""
        os.mkfifo(tmp_path / "pipe")
        regular = os.stat(asset_path("baseline.toml"))
        monkeypatch.setattr(untrusted.os, "stat", lambda *_, **__: regular)
        assert "a device, a pipe or a socket" in self.refused(tmp_path / "pipe")

    @pytest.mark.parametrize("device", ["/dev/zero", "/dev/null", "/dev/stdin", "/dev/tty"])
    def test_a_device(self, device):
        assert "cannot be read" in self.refused(device)

    def test_a_socket(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)  # the name of a socket may not be long
        with socket.socket(socket.AF_UNIX) as listener:
            listener.bind("socket")
            assert "a device, a pipe or a socket" in self.refused("socket")

    def test_a_folder(self, tmp_path):
        assert "it is a folder" in self.refused(tmp_path)

    def test_a_name_with_a_null_character(self):
        assert "no name of a file" in self.refused("a\0b")

    def test_a_link_to_a_file_is_followed(self, tmp_path):
        (tmp_path / "link").symlink_to(asset_path("baseline.toml"))
        assert read_knee(tmp_path / "link").title == packaged_knee().title

    def test_a_file_that_grows_while_it_is_read(self, tmp_path, monkeypatch):
        path = tmp_path / "knee.toml"
        path.write_text(TEXT, encoding="utf-8")
        taken = []

        def endless(_descriptor, n):
            taken.append(n)
            assert sum(taken) <= MAX_BYTES + 1, "it is read on and on"
            return b"#" * n

        monkeypatch.setattr(untrusted.os, "read", endless)
        with pytest.raises(FileFormatError, match="larger than 1,000,000 bytes"):
            read_knee(path)


HOSTILE_JSON = {
    "brackets": ("[" * 100_000, "nested 100,000 deep"),
    "closed brackets": ("[" * 65 + "]" * 65, "nested 65 deep"),
    "tables": ('{"a":' * 100_000, "nested 100,000 deep"),
    "behind a text": ('["\\"", ' + "[" * 100, "nested 101 deep"),
    "large": (" " * 1_000_001, "larger than 1,000,000 bytes"),
}


@pytest.mark.parametrize("kind", HOSTILE_JSON)
def test_hostile_json_never_reaches_the_parser(no_parser, kind):
    text, said = HOSTILE_JSON[kind]
    with pytest.raises(FileFormatError, match=said):
        untrusted.parse_json(text, 1_000_000)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('{"a": NaN}', "NaN is no number there"),
        ("[Infinity]", "Infinity is no number there"),
        ("[-Infinity]", "-Infinity is no number there"),
        ("[1e400]", "the number 1e400 is too large"),
        ("[-1e400]", "the number -1e400 is too large"),
        ("[" + "9" * 400 + "]", "a whole number has 400 digits; at most 100"),
        ("[" + "9" * 5000 + "]", "a whole number has 5,000 digits"),
        ('{"seed": 1, "a": 2, "seed": 3}', "the key 'seed' is there twice"),
        ('{"a": [{"b": 1, "b": 1}]}', "the key 'b' is there twice"),
        ('["\\ud800"]', "half a character"),
        ('{"\\uDBFF": 1}', "half a character"),
        ('["\ud800"]', "not a text that UTF-8 can hold"),
        ("{'a': 1}", "not a JSON file"),
        ("", "not a JSON file"),
    ],
)
def test_json_that_no_result_has(text, said):
    with pytest.raises(FileFormatError, match=said) as caught:
        untrusted.parse_json(text, 1_000_000)
    assert "\n" not in str(caught.value)


JSON_VALUES = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(10**60), 10**60)
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(st.characters(codec="utf-8")),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(st.characters(codec="utf-8")), inner),
)


@settings(max_examples=300, deadline=None)
@given(JSON_VALUES, st.booleans())
def test_every_honest_json_text_is_read(value, ensure_ascii):
    text = json.dumps(value, ensure_ascii=ensure_ascii)
    assert untrusted.parse_json(text, 1_000_000) == value


@settings(max_examples=300, deadline=None)
@given(st.text(st.sampled_from(string.digits + '[]{},:"\\eE+-.NaInfity \ud800'), max_size=80))
def test_any_text_is_json_or_refused_in_one_line(text):
    value, refused = outcome(untrusted.parse_json, text, 1_000_000)
    if refused:
        assert "\n" not in refused
    else:
        json.dumps(value, allow_nan=False)
