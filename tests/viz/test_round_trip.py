"""Page, knee file, result and command line: what goes out comes back, to the bit."""

import numpy as np
import pytest

from kneecore import Knee, ParameterSpace, SearchResult, SearchSettings, packaged_knee, worst_case
from kneecore.knee.file import parse_knee
from kneecore.knee.parameters import widened
from kneeviz.state.bounds import Bounds
from kneeviz.state.knee import KneeState
from kneeviz.state.presets import random_knee

BOUNDS = {
    "as they are": Bounds(),
    "half a millimetre": Bounds(geometry_mm=0.5),
    "all three": Bounds(geometry_mm=0.7, slope_deg=0.3, material_percent=7.0),
    "odd": Bounds(geometry_mm=0.123456, material_percent=9.9),
    "with rest lengths": Bounds(geometry_mm=0.45, rest_length_mm=0.3),
}
QUICK = SearchSettings(pop_size=20, n_generations=3)


@pytest.fixture(params=BOUNDS)
def state(request):
    """A page's state with a knee somewhere within its bounds."""
    state = KneeState(packaged_knee())
    state.set_bounds(BOUNDS[request.param])
    state.x = widened(random_knee(state.space, np.random.default_rng(3)), 32)
    return state


def same_bits(one, other):
    return one.tobytes() == other.tobytes()


def test_a_knee_file_comes_back_to_the_page_as_it_was(state):
    text = state.knee_text()
    again = KneeState(parse_knee(text))
    assert same_bits(again.x, state.x)
    for edge in ("lower", "upper", "baseline"):
        assert same_bits(getattr(again.space, edge), getattr(state.space, edge)), edge
    assert again.knee_text() == text
    assert again.knee.sources[:28] == state.space.sources


def test_a_half_range_is_written_as_it_was_set(state):
    line = next(one for one in state.knee_text().splitlines() if "half_range" in one)
    assert len(line) < len("half_range = 0.00012345601")


def test_the_command_line_has_the_same_box_and_finds_the_same_pair(state, tmp_path):
    path = tmp_path / "knee.toml"
    path.write_text(state.knee_text(), encoding="utf-8")
    space = ParameterSpace.from_file(path)
    assert same_bits(space.lower, state.space.lower)
    assert same_bits(space.upper, state.space.upper)
    found = worst_case(Knee(space), QUICK)
    on_page = worst_case(Knee(state.space), QUICK)
    assert same_bits(found.x, on_page.x)
    assert found.objective_model == on_page.objective_model


def test_a_result_read_back_belongs_to_the_bounds_it_was_found_in(state):
    text = worst_case(Knee(state.space), QUICK).to_json()
    again = SearchResult.from_json(text)
    assert not state.is_stale(again)
    assert not KneeState(parse_knee(state.knee_text())).is_stale(again)
    assert again.to_json() == text
