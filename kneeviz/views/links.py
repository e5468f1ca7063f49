"""What one visitor sees of links, and how his page tells the one by which he has come."""

from typing import Any

from kneeviz.jobs.messages import Post
from kneeviz.views.html.pieces import box, command_line, faint
from kneeviz.views.tabs.events import on_press, on_value

OPEN, LEAVE = "Open the linked knee", "Leave this one"


def link_text(code: str) -> str:
    """Return a link that is seen, and the command that opens the same."""
    where = f"?knee={code}"
    style = "display:block;max-height:4.5em;overflow:auto;word-break:break-all;font-size:11px"
    shown = (
        f'<a data-knee href="{where}" target="_blank" rel="noopener" style="{style}">{where}</a>'
    )
    note = faint("Who cannot reach this server, or has no token for it, opens the same by:")
    return box(shown + note + command_line(f"python -m kneeviz --knee {code}"))


def add_link_reader(gui: Any, post: Post) -> Any:
    """Add a text that is not seen, which a script in the page sets to the link."""
    reader = gui.add_text("Link", "", visible=False)
    on_value(reader, post, "link")
    return reader


def offer_link(gui: Any, post: Post) -> Any:
    """Ask one visitor whether all are to see what his link opens; return the question."""
    with gui.add_modal("A linked knee") as modal:
        gui.add_html(
            box("Everybody here will then see the linked knee. Undo brings the present one back.")
        )
        answer = gui.add_button_group("Open it?", (OPEN, LEAVE))
    on_press(answer, post, "open_link")
    return modal
