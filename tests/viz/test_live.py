"""The worst case that follows bounds and sliders, and the searches' methods."""

import threading
import time
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from searches import searched
from viz.conftest import eventually
from viz.visits import curve, press, widget
from viz.websocket_client import WebSocketClient

import kneecore
from kneecore import (
    MOMENT,
    NAMES,
    Cancelled,
    Knee,
    ModelError,
    ParameterSpace,
    SamplingSettings,
    SearchSettings,
    command_line,
    monte_carlo,
)
from kneeviz.jobs import live_search, live_worst_case
from kneeviz.jobs.live_worst_case import N_SAMPLES, LiveRequest, find
from kneeviz.server.app import App
from kneeviz.state.bounds import Bounds, with_bound
from kneeviz.state.knee import KneeState
from kneeviz.state.live import live_band

ACL_Y = NAMES.index("acl_femur_y")


def headless(space, **options):
    return searched(space, method="exact", solver="equilibrium", threads=2, **options)


def sampled_at_rest(space):
    return monte_carlo(Knee(space, solver="equilibrium"), SamplingSettings(n_samples=N_SAMPLES))


def settings(space=None):
    return LiveRequest(
        knee=Knee(space, solver="equilibrium", threads=1), search=SearchSettings(method="exact")
    )


@pytest.fixture
def live(page, visitor):
    """Live is on and has its first answer; afterwards everything is as before."""
    eventually(lambda: page.exact_ready)
    visitor.set(widget(page.view.search.live), True)
    eventually(lambda: page.live.shown)
    yield page
    visitor.set(widget(page.view.search.live), False)
    eventually(lambda: not page.live.on)
    restore_bounds(page, visitor)


def restore_bounds(page, visitor):
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), 1.0)
    eventually(lambda: page.state.bounds.geometry_mm in (None, 1.0))


def set_bound(page, visitor, mm):
    visitor.set(widget(page.view.knee.bounds["geometry_mm"]), mm)


def eventually_found(page, space):
    """Wait for the live answer of a box."""
    eventually(
        lambda: (
            page.state.result is not None
            and np.array_equal(page.state.result.model.space.lower, space.lower)
            and np.array_equal(page.state.result.model.space.upper, space.upper)
        )
    )


class TestFind:
    def test_it_is_the_headless_search_bit_by_bit(self):
        space = ParameterSpace(geometry_bound_mm=0.7, case="geometry")
        answer = find(settings(space), lambda: False, lambda _: None)
        assert answer.result.x.tobytes() == headless(space).x.tobytes()
        sampled = sampled_at_rest(space)
        spread = sampled.y
        assert live_band(answer.sampled).lower_deg.tobytes() == spread.percentile_lower.tobytes()
        assert live_band(answer.sampled).upper_deg.tobytes() == spread.percentile_upper.tobytes()

    def test_knees_that_are_not_in_the_band_are_told(self):
        wanted = settings(ParameterSpace(geometry_bound_mm=3.0))
        answer = find(wanted, lambda: False, lambda _: None)
        assert answer.sampled.n_failed > 0
        assert f"{answer.sampled.n_failed} without an equilibrium" in live_band(answer.sampled).text

    def test_it_can_be_stopped(self):
        asked = []
        with pytest.raises(Cancelled):
            find(settings(), lambda: asked.append(1) or len(asked) > 10, lambda _: None)
        assert len(asked) == 11

    def test_what_it_tells_on_the_way_are_pairs_of_the_true_model(self, monkeypatch):
        monkeypatch.setattr(live_worst_case, "FIRST_SECONDS", 0.0)
        monkeypatch.setattr(live_worst_case, "NEXT_SECONDS", 0.0)
        told, space = [], ParameterSpace(geometry_bound_mm=2.0)
        answer = find(settings(space), lambda: False, told.append)
        assert answer.result.x.tobytes() == headless(space).x.tobytes()
        assert not answer.improving
        assert len(told) > 3
        assert all(one.improving for one in told)
        f = [one.result.objective_model for one in told]
        assert f == sorted(set(f))  # what is no better is not told again
        assert f[-1] <= answer.result.objective_model + 1e-9
        y = answer.result.model.examine(told[1].result.x).y
        assert f[1] == pytest.approx(np.abs(y[0] - y[1]).sum())

    def test_a_quick_search_tells_its_end_only(self, monkeypatch):
        # Quick by its own clock: on a busy machine no search is quick by the true one.
        now = [0.0]
        monkeypatch.setattr(live_worst_case, "time", SimpleNamespace(monotonic=lambda: now[0]))
        told, looks = [], []

        def stop():
            now[0] = 0.99 * live_worst_case.FIRST_SECONDS
            looks.append(1)

        find(settings(ParameterSpace(geometry_bound_mm=0.3)), stop, told.append)
        assert len(looks) > 1
        assert told == []


class TestLatestWins:
    @pytest.fixture
    def search(self, monkeypatch):
        """A search whose answers take until they are let go; what it began; what it posted."""
        begun, go, posted = [], threading.Event(), []
        tells = []

        def slow(wanted, stop, tell):
            begun.append(wanted)
            tells.append(tell)
            while not go.wait(0.005):
                if stop():
                    raise Cancelled
            return wanted

        monkeypatch.setattr(live_search, "find", slow)
        running = live_search.LiveSearch(lambda key, value: posted.append(value))
        running.tells = tells
        yield running, begun, go, posted
        go.set()
        running.stop()

    def test_what_waits_is_replaced_and_the_slow_gives_way(self, search):
        running, begun, go, posted = search
        wanted = [settings() for _ in range(20)]
        for request in wanted:
            running.ask(request)
            eventually(lambda: begun)
        eventually(lambda: begun[-1] is wanted[-1], 5.0)
        assert len(begun) == 2
        go.set()
        eventually(lambda: posted)
        assert [(s is wanted[-1], a is wanted[-1], w) for s, a, w in posted] == [(True, True, None)]

    def test_a_quick_one_is_shown_though_another_was_asked(self, search, monkeypatch):
        running, begun, go, posted = search
        monkeypatch.setattr(live_search, "PATIENCE", 60.0)
        first, second = settings(), settings()
        running.ask(first)
        eventually(lambda: begun)
        running.ask(second)
        time.sleep(0.05)
        go.set()
        eventually(lambda: len(posted) == 2)
        assert [s for s, _, _ in posted] == [first, second]

    def test_after_its_first_word_it_gives_way_at_once(self, search, monkeypatch):
        running, begun, _, posted = search
        monkeypatch.setattr(live_search, "PATIENCE", 60.0)
        first, second = settings(), settings()
        running.ask(first)
        eventually(lambda: running.tells)
        running.tells[0]("until now")
        running.ask(second)
        eventually(lambda: begun == [first, second], 5.0)
        assert [(s, a) for s, a, _ in posted] == [(first, "until now")]

    def test_nothing_is_told_of_what_was_forgotten(self, search, monkeypatch):
        running, _, _, posted = search
        running.ask(settings())
        eventually(lambda: running.tells)
        running.forget()
        running.tells[0]("until now")
        assert posted == []

    def test_nothing_is_searched_once_it_is_forgotten(self, search, monkeypatch):
        running, begun, _, posted = search
        monkeypatch.setattr(live_search, "PATIENCE", 0.0)
        running.ask(settings())
        eventually(lambda: begun)
        running.forget()
        time.sleep(0.1)
        assert posted == []

    def test_a_fault_is_posted_and_the_thread_goes_on(self, monkeypatch):
        posted = []

        def failing(wanted, stop, tell):
            raise ModelError("no knee")

        monkeypatch.setattr(live_search, "find", failing)
        running = live_search.LiveSearch(lambda key, value: posted.append(value))
        try:
            for n in (1, 2):
                running.ask(settings())
                eventually(lambda n=n: len(posted) == n)
            assert [why for _, _, why in posted] == ["no knee", "no knee"]
        finally:
            running.stop()


class TestAroundTheKnee:
    def test_the_box_is_around_the_knee_and_the_pose_the_baselines(self):
        state = KneeState(kneecore.packaged_knee())
        assert state.space_around_knee() is state.space
        state.set_bounds(with_bound(Bounds(), "geometry_mm", 0.5))
        state.x[ACL_Y] += 0.3e-3
        space = state.space_around_knee()
        np.testing.assert_array_equal(space.centre, state.x[:28])
        np.testing.assert_array_equal(space.baseline, state.space.baseline)
        width = state.space.upper - state.space.lower
        np.testing.assert_allclose(space.upper - space.lower, width, rtol=1e-9)


class TestLive:
    def test_a_bound_moves_both_knees_and_the_band(self, live, visitor):
        set_bound(live, visitor, 0.7)
        space = ParameterSpace(geometry_bound_mm=0.7)
        eventually_found(live, space)
        wanted = headless(space)
        assert live.state.result.x.tobytes() == wanted.x.tobytes()
        spread = sampled_at_rest(space).y

        def drawn(client):
            data = curve(client, live)
            shown = [np.interp(MOMENT, data[0][1:-1], data[i][1:-1]) for i in (3, 4, -5, -4)]
            right = [spread.percentile_lower, spread.percentile_upper]
            right += [np.degrees(wanted.responses[n].flexion) for n in ("model_1", "model_2")]
            return np.allclose(shown, right, atol=1e-9)

        visitor.wait(drawn)
        found = visitor.props[widget(live.view.found)]["content"]
        assert "at rest" in found
        assert "climbs end here" in found
        assert "Bounds changed" not in found
        legend = visitor.props[widget(live.view.curve_legend)]["content"]
        assert "2,000 knees at rest" in legend

    def test_a_slider_takes_the_box_along(self, live, visitor):
        visitor.set(widget(live.view.knee.sliders[ACL_Y]), 0.4)
        eventually(lambda: live.state.x[ACL_Y] == pytest.approx(0.4e-3))
        centre = np.array(live.state.space.baseline)
        centre[ACL_Y] = 0.4e-3
        space = ParameterSpace(centre=centre)
        eventually_found(live, space)
        assert live.state.result.x.tobytes() == headless(space).x.tobytes()
        assert "--around current" in command_line(live.state.result)
        table = widget(live.view.search.table)
        visitor.wait(lambda c: "--around current" in c.props[table]["content"])

    def test_a_storm_ends_with_the_last_bounds(self, live, visitor):
        sent = np.linspace(0.3, 1.4, 150).round(3)
        for mm in sent:
            set_bound(live, visitor, float(mm))
            time.sleep(0.005)
        space = ParameterSpace(geometry_bound_mm=float(sent[-1]))
        eventually_found(live, space)
        time.sleep(0.5)  # nothing older comes after it
        assert live.state.result.x.tobytes() == headless(space).x.tobytes()
        assert not live.live.slow

    def test_sliders_and_surrogate_follow_when_the_hand_rests(self, live, visitor):
        old = live.state.surrogate
        set_bound(live, visitor, 0.5)
        eventually_found(live, ParameterSpace(geometry_bound_mm=0.5))
        slider = widget(live.view.knee.sliders[0])
        visitor.wait(lambda c: c.props[slider]["max"] == pytest.approx(-13.5))
        eventually(lambda: live.state.surrogate not in (None, old))
        assert live.state.surrogate.model.space is live.state.space

    def test_the_loads_that_count_are_followed_too(self, live, visitor):
        visitor.set(widget(live.view.search.options.handles["objective"]), "extension")
        eventually(lambda: live.state.result.settings.objective == "extension")
        wanted = headless(ParameterSpace(), objective="extension")
        assert live.state.result.x.tobytes() == wanted.x.tobytes()
        visitor.set(widget(live.view.search.options.handles["objective"]), "all")
        eventually(lambda: live.state.result.settings.objective == "all")

    def test_wide_bounds_say_so_and_give_way(self, live, visitor):
        note = widget(live.view.search.live_note)
        set_bound(live, visitor, 6.0)
        words = ("take longer", "improving")
        visitor.wait(lambda c: any(word in c.props[note]["content"] for word in words))
        visitor.wait(lambda c: np.isnan(curve(c, live)[3]).all())  # the old bounds' band has gone
        set_bound(live, visitor, 0.6)
        eventually_found(live, ParameterSpace(geometry_bound_mm=0.6))
        visitor.wait(lambda c: not any(word in c.props[note]["content"] for word in words))

    def test_a_first_answer_is_marked_and_then_improved(self, live, visitor, monkeypatch):
        """A search that is slow on purpose, of which each report waits for its turn."""
        space, turns = ParameterSpace(geometry_bound_mm=2.0), threading.Semaphore(0)
        plain = kneecore.worst_case

        def slow(model, search, *, callback):
            def watch(progress):
                while not turns.acquire(timeout=0.02):
                    if callback(replace(progress, so_far=None)):
                        return True
                return callback(progress)

            return plain(model, search, callback=watch)

        monkeypatch.setattr(kneecore, "worst_case", slow)
        monkeypatch.setattr(live_worst_case, "FIRST_SECONDS", 0.0)
        monkeypatch.setattr(live_worst_case, "NEXT_SECONDS", 0.0)
        note, found = widget(live.view.search.live_note), widget(live.view.found)
        set_bound(live, visitor, 2.0)
        turns.release(8)
        visitor.wait(lambda c: "improving" in c.props[note]["content"])
        visitor.wait(lambda c: "improving" in c.props[found]["content"])
        visitor.wait(lambda c: np.isnan(curve(c, live)[3]).all())  # no band of other bounds
        eventually_found(live, space)
        first = live.state.result
        assert "without a browser" not in visitor.props[widget(live.view.search.table)]["content"]
        y = first.model.examine(first.x).y
        assert first.objective_model == pytest.approx(np.abs(y[0] - y[1]).sum())
        turns.release(8)
        eventually(lambda: live.state.result.objective_model > first.objective_model)
        assert live.live.improving
        turns.release(10_000)
        eventually(lambda: not live.live.improving)
        visitor.wait(lambda c: "improving" not in c.props[note]["content"])
        visitor.wait(lambda c: "improving" not in c.props[found]["content"])
        visitor.wait(lambda c: np.isfinite(curve(c, live)[3]).any())
        blocking = headless(space)
        assert live.state.result.x.tobytes() == blocking.x.tobytes()
        assert live.state.result.stop_reason == "converged"

    def test_what_was_only_the_best_until_now_says_so_when_live_ends(
        self, live, visitor, monkeypatch
    ):
        monkeypatch.setattr(live_worst_case, "FIRST_SECONDS", 0.0)
        plain, hold = kneecore.worst_case, threading.Event()

        def endless(model, search, *, callback):
            def watch(progress):
                told = callback(progress)
                while progress.so_far is not None and not callback(progress):
                    if hold.wait(0.02):
                        return told
                return told or progress.so_far is not None

            return plain(model, search, callback=watch)

        monkeypatch.setattr(kneecore, "worst_case", endless)
        set_bound(live, visitor, 1.7)
        eventually(lambda: live.live.improving)
        visitor.set(widget(live.view.search.live), False)
        found = widget(live.view.found)
        visitor.wait(lambda c: "until then" in c.props[found]["content"])
        assert "improving" not in visitor.props[found]["content"]
        hold.set()

    def test_off_keeps_the_knees_and_drops_the_band(self, live, visitor):
        visitor.wait(lambda c: np.isfinite(curve(c, live)[3]).any())
        result = live.state.result
        visitor.set(widget(live.view.search.live), False)
        visitor.wait(lambda c: np.isnan(curve(c, live)[3]).all())
        assert live.state.result is result
        assert live.overlay
        visitor.set(widget(live.view.knee.sliders[ACL_Y]), 0.1)
        eventually(lambda: live.state.x[ACL_Y] == pytest.approx(0.1e-3))
        time.sleep(0.3)
        assert live.state.result is result

    def test_off_greys_what_was_around_another_knee(self, live, visitor):
        visitor.set(widget(live.view.knee.sliders[ACL_Y]), 0.3)
        eventually(lambda: not live.state.result.model.space.is_around_baseline)
        visitor.set(widget(live.view.search.live), False)
        found = widget(live.view.search.found)
        visitor.set(widget(live.view.knee.sliders[ACL_Y]), 0.1)
        visitor.wait(lambda c: "Knee or bounds changed" in c.props[found]["content"])
        visitor.set(widget(live.view.knee.sliders[ACL_Y]), 0.3)
        visitor.wait(lambda c: "Knee or bounds changed" not in c.props[found]["content"])

    def test_no_worst_case_is_told_and_nothing_old_stands(self, live, visitor, monkeypatch):
        def failing(wanted, stop, tell):
            raise ModelError("all of <them> failed")

        with monkeypatch.context() as patched:
            patched.setattr(live_search, "find", failing)
            set_bound(live, visitor, 0.9)
            note = widget(live.view.search.live_note)
            visitor.wait(lambda c: "all of &lt;them&gt; failed" in c.props[note]["content"])
            eventually(lambda: not live.overlay)
            visitor.wait(lambda c: np.isnan(curve(c, live)[3]).all())
        set_bound(live, visitor, 1.1)
        eventually_found(live, ParameterSpace(geometry_bound_mm=1.1))
        eventually(lambda: live.overlay)

    def test_hidden_knees_stay_hidden(self, live, visitor):
        visitor.set(widget(live.view.search.overlay), False)
        eventually(lambda: not live.overlay)
        set_bound(live, visitor, 0.8)
        eventually_found(live, ParameterSpace(geometry_bound_mm=0.8))
        assert not live.overlay

    def test_a_search_ends_it(self, live, visitor):
        press(visitor, live.view.search.surrogate)
        eventually(
            lambda: (
                live.search.job is None and live.state.result.settings.search_space == "surrogate"
            )
        )
        assert not live.live.on
        visitor.wait(lambda c: c.values[widget(live.view.search.live)] is False)


def test_a_visitor_who_leaves_takes_the_thread_along():
    def searching():
        return {t for t in threading.enumerate() if t.name in ("live", "view")}

    before = searching()
    app = App(port=0, shared=False)
    try:
        with WebSocketClient(app.server.get_port()) as one:
            eventually(lambda: len(app.sessions) == 1)
            page = next(iter(app.sessions.values())).page
            one.wait(lambda c: widget(page.view.search.live) in c.values)
            one.set(widget(page.view.search.live), True)
            eventually(lambda: page.live.shown)
            assert {t.name for t in searching() - before} == {"live", "view"}
        eventually(lambda: searching() == before)
    finally:
        app.stop()


class TestMethods:
    @pytest.fixture(autouse=True)
    def restore(self, page, visitor):
        yield
        tab = page.view.search
        visitor.set(widget(tab.options.handles["method"]), "Genetic")
        visitor.set(widget(tab.solver), "In motion")
        eventually(
            lambda: (
                tab.options.handles["method"].value == "Genetic" and tab.solver.value == "In motion"
            )
        )

    @pytest.mark.parametrize("where", ["model", "surrogate"])
    def test_an_exact_search_with_its_evidence(self, page, visitor, where):
        tab = page.view.search
        visitor.set(widget(tab.options.handles["method"]), "Exact gradients")
        visitor.wait(lambda c: c.props[widget(tab.options.handles["pop_size"])]["disabled"])
        visitor.set(widget(tab.solver), "At rest")
        eventually(lambda: tab.solver.value == "At rest")
        page.state.result = None
        press(visitor, getattr(tab, where))
        eventually(lambda: page.search.job is None and page.state.result is not None)
        result = page.state.result
        wanted = searched(method="exact", search_space=where, solver="equilibrium")
        assert result.x.tobytes() == wanted.x.tobytes()
        found = widget(tab.found)
        climbs = f"of {wanted.evidence.n_climbs} climbs"
        visitor.wait(lambda c: climbs in c.props[found]["content"])
        command = visitor.props[widget(tab.table)]["content"]
        assert "--solver equilibrium --method exact" in command
        assert ("--space surrogate" in command) == (where == "surrogate")
        visitor.set(widget(tab.options.handles["method"]), "Genetic")
        visitor.wait(lambda c: not c.props[widget(tab.options.handles["pop_size"])]["disabled"])

    def test_a_repaired_surrogate_tells_its_gaps(self, page, visitor):
        tab = page.view.search
        visitor.set(widget(tab.options.handles["method"]), "Exact gradients")
        visitor.set(widget(tab.options.handles["repair"]), True)
        eventually(
            lambda: (
                tab.options.handles["method"].value == "Exact gradients"
                and tab.options.handles["repair"].value
            )
        )
        page.state.result = None
        press(visitor, tab.surrogate)
        eventually(lambda: page.search.job is None and page.state.result is not None)
        wanted = searched(method="exact", repair=True)
        assert page.state.result.x.tobytes() == wanted.x.tobytes()
        told = f"Repaired with {wanted.repair.n_models} more models"
        visitor.wait(lambda c: told in c.props[widget(tab.found)]["content"])
        assert "--repair" in visitor.props[widget(tab.table)]["content"]
        press(visitor, tab.model)  # the true model has no surrogate to be repaired
        eventually(lambda: page.state.result.settings.search_space == "model")
        visitor.set(widget(tab.options.handles["repair"]), False)
        eventually(lambda: not tab.options.handles["repair"].value)
