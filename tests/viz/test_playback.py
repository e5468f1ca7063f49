from itertools import pairwise

import pytest

from kneeviz.state.playback import RETURN_SECONDS, RUN_RATE, RUN_SECONDS, SWEEP_SECONDS, Playback


def run(playback, seconds, rate=30.0, start=100.0):
    shares = []
    for i in range(round(seconds * rate) + 1):
        playback.advance(start + i / rate)
        shares.append(playback.share)
    return shares


def test_it_swings_from_straight_to_bent_and_back():
    shares = run(Playback(), 2 * SWEEP_SECONDS)
    assert max(shares) > 0.999
    assert shares[0] == 0.0
    assert shares[-1] < 1e-3


@pytest.mark.parametrize("mode", ["sweep", "extension"])
def test_motion_never_jumps_even_where_it_loops(mode):
    playback = Playback(mode=mode)
    shares = run(playback, 2.2 * RUN_SECONDS / RUN_RATE)
    steps = [abs(b - a) for a, b in pairwise(shares)]
    assert max(steps) < 0.08


def test_its_pace_does_not_depend_on_the_frame_rate():
    slow, fast = Playback(), Playback()
    assert run(slow, 4.0, rate=8.0)[-1] == pytest.approx(run(fast, 4.0, rate=60.0)[-1])


def test_speed_doubles_the_pace():
    slow, fast = Playback(speed=1.0), Playback(speed=2.0)
    assert run(slow, 4.0)[-1] == pytest.approx(run(fast, 2.0)[-1])


def test_paused_it_stands_still():
    playback = Playback(playing=False)
    playback.set_share(0.3)
    assert run(playback, 2.0)[-1] == pytest.approx(0.3)


def test_a_long_gap_is_no_leap():
    playback = Playback()
    playback.advance(0.0)
    playback.advance(1000.0)
    assert playback.share < 0.1


@pytest.mark.parametrize("share", [-1.0, 0.0, 0.25, 1.0, 7.0])
def test_set_share(share):
    playback = Playback()
    playback.set_share(share)
    assert playback.share == pytest.approx(min(max(share, 0.0), 1.0))


def test_without_loop_each_play_goes_to_the_other_end():
    playback = Playback(loop=False)
    run(playback, SWEEP_SECONDS + 1.0)
    assert not playback.playing
    assert playback.share == pytest.approx(1.0)
    playback.play(True)
    run(playback, SWEEP_SECONDS + 1.0)
    assert playback.share == pytest.approx(0.0)


def test_a_run_in_time_ends_and_starts_again():
    playback = Playback(mode="flexion", loop=False)
    run(playback, RUN_SECONDS / RUN_RATE + 1.0)
    assert (playback.playing, playback.share) == (False, 1.0)
    playback.play(True)
    assert playback.share == 0.0


def test_a_looping_run_eases_back():
    playback = Playback(mode="flexion")
    playback.set_share(1.0)
    shares = run(playback, 0.9 * RETURN_SECONDS)
    assert 0.0 < shares[-1] < 0.1


def test_changing_the_mode_starts_afresh():
    playback = Playback()
    playback.set_share(0.8)
    playback.set_mode("extension")
    assert playback.share == 0.0
