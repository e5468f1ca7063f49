"""Points are cut by what a run costs, and come back in order, none of them twice."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kneecore.runs.chunks import MOST_ROWS, Cutter, Pace
from kneecore.runs.engine import Engine
from kneecore.runs.options import RunOptions
from kneecore.runs.work import BatchWork, RowWork


def test_the_first_chunks_are_small():
    assert Pace(by_row=True).rows(8, None) == 1
    assert Pace(by_row=False).rows(8, None) == 16


@pytest.mark.parametrize(
    ("cost_s", "n_workers", "left", "rows"),
    [
        (10.0, 4, None, 1),  # a slow run is a chunk of its own
        (0.01, 4, None, 25),  # a quarter of a second
        (0.01, 1000, None, 400),  # 4 ms a worker: a scheduler has to give out all of them
        (0.01, 4, 40, 5),  # towards the end smaller, so that all end together
        (0.01, 1, 40, 25),
        (1e-9, 4, None, MOST_ROWS),
    ],
)
def test_a_chunk_is_as_long_as_its_runs_cost(cost_s, n_workers, left, rows):
    pace = Pace(by_row=True)
    pace.measured(20_000, 20_000 * cost_s)
    assert pace.rows(n_workers, left) == rows


def test_chunks_grow_step_by_step():
    pace = Pace(by_row=True)
    pace.measured(1, 1e-5)
    assert pace.rows(4, None) == 8
    pace.measured(8, 8e-5)
    assert pace.rows(4, None) == 64
    pace.measured(1, 1.0)  # a late small one says little
    assert pace.rows(4, None) >= 3


@given(
    lengths=st.lists(st.integers(min_value=0, max_value=50), max_size=8),
    cost=st.floats(min_value=1e-6, max_value=1.0),
)
def test_nothing_is_lost_between_batches(lengths, cost):
    rows = np.arange(sum(lengths), dtype=float)[:, None]
    batches = np.split(rows, np.cumsum(lengths)[:-1]) if lengths else []
    pace = Pace(by_row=True)
    cutter, cut, start = Cutter(batches, pace), [], 0
    while (chunk := cutter.next(3)) is not None:
        assert chunk[0] == start
        start += len(chunk[1])
        cut.append(chunk[1])
        pace.measured(len(chunk[1]), cost * len(chunk[1]))
    np.testing.assert_array_equal(np.concatenate([np.empty((0, 1)), *cut]), rows)
    assert list(cutter.lengths) == lengths


@settings(deadline=None, max_examples=25)
@given(
    lengths=st.lists(st.integers(min_value=0, max_value=300), min_size=1, max_size=6),
    batched=st.booleans(),
)
def test_a_stream_comes_back_as_it_was_sent(lengths, batched):
    rows = np.arange(sum(lengths), dtype=float)[:, None]
    batches = np.split(rows, np.cumsum(lengths)[:-1])
    work = BatchWork(lambda x: x, 1) if batched else RowWork(lambda x: x, 1)
    engine = Engine(RunOptions(workers=_Shuffled()), digest="")
    done = list(engine.stream(work, batches))
    assert [len(d.y) for d in done] == lengths
    np.testing.assert_array_equal(np.concatenate([d.y for d in done]), rows)


class _Shuffled:
    """An executor whose chunks come back in another order."""

    def __init__(self):
        self._waiting, self._rng = [], np.random.default_rng(0)

    def map(self, function, given):
        given = list(given)
        for k in self._rng.permutation(len(given)):
            given[k] = function(given[k])
        return given
