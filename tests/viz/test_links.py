"""Links that open a state: exact to the bit, and refused in a line when they are nonsense."""

import base64
import contextlib
import json
import math
import random
import zlib
from dataclasses import replace

import numpy as np
import pytest
from viz.conftest import eventually
from viz.visits import press, widget
from viz.websocket_client import WebSocketClient

from kneecore import KneecoreError, ParameterError, asset_path, packaged_knee, parse_knee
from kneecore.knee.parameters import widened
from kneeviz.server.app import App
from kneeviz.state import links, saved
from kneeviz.state.bounds import WIDTH, Bounds
from kneeviz.state.snapshot import Snapshot
from kneeviz.views.links import LEAVE, OPEN

KNEE = asset_path("baseline.toml").read_text(encoding="utf-8")
FIRST = (("search.seed", 0), ("search.pop_size", 200), ("study.scramble", True))
NEW = Snapshot(
    knee=packaged_knee(),
    bounds=Bounds(),
    x=widened(packaged_knee().baseline, WIDTH),
    settings=FIRST,
)
ODD = replace(
    NEW,
    x=NEW.x * (1.0 + 1e-3 * np.random.default_rng(1).standard_normal(WIDTH)),
    bounds=Bounds(case="geometry", geometry_mm=0.1 + 0.2, rest_length="fixed"),
    settings=(("search.seed", 7), *FIRST[1:]),
)


def packed(content):
    text = content if isinstance(content, bytes) else json.dumps(content).encode()
    return base64.urlsafe_b64encode(zlib.compress(text)).decode().rstrip("=")


def of_ours(**content):
    return packed({"schema": links.SCHEMA} | content)


def opened(code):
    """The state in a link, with the settings of a new page for those that it does not name."""
    state = links.from_code(code)
    return replace(state, settings=tuple((dict(FIRST) | dict(state.settings)).items()))


def another_baseline():
    knee = parse_knee(KNEE.replace('title = "Packaged baseline"', 'title = "Mine é"'))
    return replace(ODD, knee=knee)


class TestCode:
    @pytest.mark.parametrize("state", [NEW, ODD, another_baseline()], ids=["new", "odd", "own"])
    def test_a_link_gives_the_same_state_to_the_bit(self, state):
        code = links.to_code(state, FIRST)
        assert saved.to_text(opened(code)) == saved.to_text(state)
        assert links.to_code(state, FIRST) == code
        assert len(code) < links.MOST_CHARACTERS / 2

    def test_minus_zero_is_no_zero(self):
        x = NEW.x.copy()
        x[-1] = -0.0
        again = links.from_code(links.to_code(replace(NEW, x=x), FIRST))
        assert math.copysign(1.0, again.x[-1]) == -1.0

    def test_a_baseline_too_long_for_an_address_is_told(self):
        words = "".join(map(chr, random.Random(1).choices(range(0x4E00, 0x9F00), k=4000)))
        knee = replace(another_baseline().knee, note=words)
        with pytest.raises(KneecoreError, match=r"at most 6,000 are allowed; the file knee\.toml"):
            links.to_code(replace(NEW, knee=knee), FIRST)

    @pytest.mark.parametrize(
        ("code", "why"),
        [
            ("", "characters"),
            ("a b", "characters"),
            ("é", "characters"),
            ("A" * 6001, "6,001 characters"),
            ("A", "not whole"),
            ("AAAA", "not whole"),
            (links.to_code(ODD, FIRST)[:-9], "not whole"),
            (links.to_code(ODD, FIRST) + "AAAA", "not whole"),
            (packed(b"0" * 4_000_000), "more than 65,536 bytes"),
            (packed(b"\xff"), "not whole"),
            (packed(b"[" * 60_000), "deep"),
            (packed([]), "JSON object"),
            (packed({}), "`schema`"),
            (packed({"schema": "kneeviz.link/2"}), "'kneeviz.link/1' is allowed"),
            (of_ours(result={}), "'result' is unknown"),
            (of_ours(knee=[1.0]), "`knee` is no table"),
            (of_ours(knee={"nose_x": 1.0}), "unknown parameter"),
            (of_ours(knee={"condyle_x": "1"}), "32 numbers"),
            (of_ours(knee={"condyle_radius": -1.0}), "condyle_radius"),
            (of_ours(bounds={"size": 1.0}), "`bounds` must name"),
            (of_ours(bounds={"geometry_mm": -1.0}), "bound"),
            (of_ours(baseline=3), "no text"),
            (of_ours(baseline="a = "), "TOML"),
        ],
        ids=lambda value: str(value)[:24],
    )
    def test_nonsense_is_refused_in_a_line(self, code, why):
        with pytest.raises(KneecoreError, match=why) as told:
            links.from_code(code)
        assert "\n" not in str(told.value)

    def test_whatever_the_values_are_it_is_a_state_or_told(self):
        values = [None, True, [], {}, "x", 0, -1, 1e308, 1e-320, 10**99, [[1.0]], {"a": {}}]
        names = ["case", "geometry_mm", "slope_deg", "material_percent", "rest_length"]
        for value in values:
            tables = [{"bounds": {name: value}} for name in names]
            tables += [{"knee": {"condyle_x": value}}, {"settings": value}, {"baseline": value}]
            tables += [{"bounds": value}, {"knee": value}, {"settings": {"search.seed": value}}]
            for table in tables:
                with contextlib.suppress(KneecoreError):
                    links.from_code(of_ours(**table))


def text_widget(visitor):
    """The widget that the script in this visitor's page sets."""
    found = [u for u, props in visitor.props.items() if props.get("label") == "Link"]
    return found[0] if found else None


def comes_with(visitor, code):
    """Do as the script does in a page that was opened with ``?knee=``."""
    visitor.set(visitor.wait(text_widget), code)


def is_told(visitor, words):
    visitor.wait(lambda c: any(words in n["props"]["body"] for n in c.notifications))


def question(visitor):
    """The widget that asks whether to open the link, if it is there."""
    found = (u for u, p in visitor.props.items() if list(p.get("options", ())) == [OPEN, LEAVE])
    return next(found, None)


def text_of(page):
    return saved.to_text(page.snapshot())


def code_of(page, **changes):
    return links.to_code(replace(page.snapshot(), **changes), page.view.first_settings)


class TestShared:
    def test_a_copied_link_opens_the_same_after_a_yes_and_can_be_undone(self, page, visitor):
        visitor.set(widget(page.view.knee.sliders[0]), -13.3)
        eventually(lambda: page.history.present.x[0] != page.state.space.baseline[0])
        linked = text_of(page)
        press(visitor, page.view.files.copy)
        shown = widget(page.view.files.link)
        code = visitor.wait(
            lambda c: c.props[shown]["content"].partition("?knee=")[2].partition('"')[0]
        )
        assert f"python -m kneeviz --knee {code}<" in visitor.props[shown]["content"]
        page.post("reset_all")
        visitor.wait(lambda c: c.props[shown]["content"] == "")
        visitor.set(widget(page.view.search.options.handles["pop_size"]), 100)
        eventually(lambda: dict(page.history.present.settings)["search.pop_size"] == 100)
        before = text_of(page)
        with WebSocketClient(visitor.port) as other:
            comes_with(other, code)
            asked = other.wait(question)
            assert text_of(page) == before, "nobody has said yes"
            assert question(visitor) is None, "only he is asked"
            other.set(asked, OPEN)
            eventually(lambda: text_of(page) == linked)
        page.post("undo")
        eventually(lambda: text_of(page) == before)
        page.post("start_over")
        eventually(lambda: page.snapshot().same_as(page.history.start))

    def test_after_a_no_all_stays(self, page, visitor):
        before = text_of(page)
        comes_with(visitor, code_of(page, bounds=Bounds(geometry_mm=0.5)))
        visitor.set(visitor.wait(question), LEAVE)
        eventually(lambda: page.links.offered == {})
        assert text_of(page) == before

    @pytest.mark.parametrize("code", ["nonsense!", "AAAA", of_ours(settings={"colour": 1})])
    def test_nonsense_leaves_all_as_it_is_and_one_line_tells(self, page, visitor, code):
        before = text_of(page)
        comes_with(visitor, code)
        is_told(visitor, "What was there stands.")
        assert len(visitor.notifications) == 1
        assert text_of(page) == before

    @pytest.mark.parametrize("value", ["A" * 8001, [3]])
    def test_what_is_no_text_does_not_arrive(self, page, visitor, value):
        comes_with(visitor, value)
        is_told(visitor, "it is no short text")


class TestOfOnesOwn:
    @pytest.fixture
    def own(self):
        half = replace(NEW, bounds=Bounds(geometry_mm=0.5))
        running = App(port=0, shared=False, link=links.to_code(half, FIRST))
        yield running
        running.stop()

    def test_a_page_opens_with_the_servers_link_and_at_once_with_the_visitors(self, own):
        with WebSocketClient(own.server.get_port()) as visitor:
            reader = visitor.wait(text_widget)
            page = next(iter(own.sessions.values())).page
            assert page.state.bounds.geometry_mm == 0.5
            first = page.view.first_settings
            visitor.set(reader, links.to_code(replace(ODD, settings=first), first))
            eventually(lambda: page.history.present.x.tobytes() == ODD.x.tobytes())
            assert page.state.bounds == ODD.bounds

    def test_a_link_has_a_knee_itself(self):
        with pytest.raises(ParameterError, match="`link` is given with"):
            App(port=0, link=links.to_code(NEW, FIRST), knee=packaged_knee())
