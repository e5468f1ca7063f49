"""Who may change the shared page of a class: the teacher, all, or the teacher and one more.

The rule is kept at the door: what somebody sends who may only watch is dropped where his messages
are read, before viser has seen it. Pages only show what holds.
"""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import viser

from kneeviz import viser_internals, viser_scripts
from kneeviz.views.teach import ALL, TEACHER, WATCHING, TeachBox, role_of

Refused = Callable[[int, Any, str, Any], None]
"""Called with the visitor's number, the widget, why, and None, as `viser_internals.Reject`."""


@dataclass(frozen=True, kw_only=True)
class Rule:
    """Who may change the page beside the teacher. Never altered: it is read without a lock."""

    everybody: bool = False
    one: Any = None
    """The connection of the one who has the wheel, or None."""

    def lets(self, connection: Any) -> bool:
        """Tell whether what a connection sends counts."""
        return bool(connection.leads) or self.everybody or connection is self.one


@dataclass(frozen=True, kw_only=True)
class _Person:
    """Somebody who is here."""

    client: viser.ClientHandle
    connection: Any
    number: int
    """A small one, for people; 0 for a teacher."""
    box: TeachBox | None

    @property
    def name(self) -> str:
        return f"Visitor {self.number}"


class Classroom:
    """The visitors of a shared page, of whom only some may change it.

    Any thread may call it, and none waits for long: who is here and who drives changes under its
    lock, together with what the pages show of it.
    """

    def __init__(self) -> None:
        self.rule = Rule()
        self._lock = threading.Lock()
        self._people: dict[int, _Person] = {}

    def open(self, server: viser.ViserServer, refused: Refused) -> None:
        """Begin; `refused` tells visitors of what was dropped."""
        self._server, self._refused = server, refused

    def lets(self, connection: Any) -> bool:
        """Tell whether what a connection sends counts; its camera is its own and always does."""
        return self.rule.lets(connection)

    def dropped(self, connection: Any, message: Any) -> None:
        """Tell a visitor that what he sent does not count, and show him what holds."""
        person = next((p for p in list(self._people.values()) if p.connection is connection), None)
        if person is None:
            return
        number = person.client.client_id
        widget = viser_internals.dropped(self._server.gui, number, message)
        self._refused(number, widget, WATCHING, None)

    def arrive(self, client: viser.ClientHandle) -> None:
        """Note that somebody is here; a teacher gets his switch."""
        number = client.client_id
        connection = viser_internals.connection_of(self._server, number)
        if connection is None:
            return  # gone while this waited for its turn
        leads = bool(connection.leads)
        box = TeachBox(client.gui, self._asked) if leads else None
        if leads:
            viser_scripts.hide_token(client)
        with self._lock:
            if number not in self._server.get_clients():
                return  # gone meanwhile; who goes from now on is struck out by `leave`
            shown = 0 if leads else self._free_number()
            self._people[number] = _Person(
                client=client, connection=connection, number=shown, box=box
            )
            self._show()

    def leave(self, client_id: int) -> None:
        """Note that somebody has left; the wheel does not go with him."""
        with self._lock:
            person = self._people.pop(client_id, None)
            if person is not None and person.connection is self.rule.one:
                self.rule = Rule()
            self._show()

    def give(self, driver: str) -> None:
        """Let the teacher drive alone, or everybody, or the teacher and one more, by his name."""
        with self._lock:
            named = (p for p in self._people.values() if p.box is None and p.name == driver)
            one = next(named, None)
            self.rule = Rule(everybody=driver == ALL, one=None if one is None else one.connection)
            for number, person in self._people.items():
                if not self.lets(person.connection):
                    viser_internals.end_drags(self._server, number)
            self._show()

    def _asked(self, _key: Any, value: Any) -> None:
        self.give(value.value)

    def _free_number(self) -> int:
        taken = {person.number for person in self._people.values()}
        return next(n for n in range(1, len(taken) + 2) if n not in taken)

    @property
    def driver(self) -> str:
        """Who drives, as the switch names it."""
        if self.rule.everybody:
            return ALL
        drives = (p.name for p in self._people.values() if p.connection is self.rule.one)
        return next(drives, TEACHER)

    def _show(self) -> None:
        """Let the pages show who drives."""
        names = [p.name for p in sorted(self._people.values(), key=lambda p: p.number) if p.number]
        here = self._server.get_clients()
        for person in (p for number, p in self._people.items() if number in here):
            if person.box is not None:
                person.box.show(self.driver, names)
            else:
                drives = self.lets(person.connection)
                line = role_of(person.name, drives=drives, all_drive=self.rule.everybody)
                viser_scripts.show_role(person.client, line, drives=drives)
            person.client.flush()
