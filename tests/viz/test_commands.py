from viz.conftest import eventually
from viz.visits import pause, search_anew

from kneeviz.actions.table import ACTIONS
from kneeviz.views.commands import COMMANDS


def give(visitor, page, label):
    """Do what the key of a command does."""
    at = next(n for n, one in enumerate(COMMANDS) if one.label == label)
    visitor.send({"type": "CommandTriggerMessage", "uuid": page.view.commands[at]._impl.uuid})


def test_every_command_is_an_action_and_has_a_key_of_its_own():
    keys = [(one.hotkey, one.modifier) for one in COMMANDS if one.hotkey is not None]
    assert len(set(keys)) == len(keys)
    assert len({one.label for one in COMMANDS}) == len(COMMANDS)
    for one in COMMANDS:
        assert (one.key[0] if isinstance(one.key, tuple) else one.key) in ACTIONS


def test_motion_and_view_from_the_keyboard(page, visitor):
    playing = page.playback.playing
    give(visitor, page, "Play or pause")
    eventually(lambda: page.playback.playing is not playing)
    pause(visitor, page)
    give(visitor, page, "Bent")
    eventually(lambda: page.playback.share == 1.0)
    give(visitor, page, "A little straighter")
    eventually(lambda: abs(page.playback.share - 0.95) < 1e-12)
    give(visitor, page, "View in 3D")
    eventually(lambda: page.view.scene.spatial)
    give(visitor, page, "Flat view")
    eventually(lambda: not page.view.scene.spatial)
    dark = page.view.dark
    give(visitor, page, "Dark or light theme")
    eventually(lambda: page.view.dark is not dark and page.view.look.dark.value is not dark)
    give(visitor, page, "Dark or light theme")
    eventually(lambda: page.view.dark is dark)
    give(visitor, page, "Newtons beside the ligaments")
    eventually(lambda: page.view.scene.forces and page.view.look.forces.value)


def test_what_cannot_be_done_is_told(page, visitor):
    page.state.result = None
    give(visitor, page, "Show or hide both worst cases")
    visitor.wait(lambda c: any("No search" in str(n) for n in c.notifications))
    assert not page.overlay


def test_overlays_and_the_live_search_from_the_keyboard(page, visitor):
    search_anew(page, visitor)
    eventually(lambda: page.overlay)
    give(visitor, page, "Show or hide both worst cases")
    eventually(lambda: not page.overlay and not page.view.search.overlay.value)
    eventually(lambda: page.exact_ready)
    give(visitor, page, "Live worst case on or off")
    eventually(lambda: page.live.on and page.view.search.live.value)
    give(visitor, page, "Live worst case on or off")
    eventually(lambda: not page.live.on)
