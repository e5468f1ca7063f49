"""Rows of the wire: strangers, hostile messages, and visitors who do not behave."""

import threading
import time

from hardening import attacks
from hardening.leavers import Watchdog, hail_of_leavers
from hardening.rows import Guard, Outcome, Scale, row
from hardening.served import Honest, Served, serving
from viz.websocket_client import WebSocketClient
from websockets.exceptions import InvalidStatus

from kneeviz.server.app import MAX_SESSIONS, App


def told(honest: Honest, served: Served, before_mb: float) -> str:
    """Return how the honest visitor fared meanwhile, and what the server holds."""
    state = "answered rightly" if honest.failure is None else f"failed ({honest.failure})"
    return (
        f"{len(honest.seconds)} slider moves of an honest visitor {state}, "
        f"95 % within {honest.p95_ms:.0f} ms; memory {served.memory_mb - before_mb:+.0f} MB"
    )


def fared_well(honest: Honest, served: Served, before_mb: float, most_mb: float = 150.0) -> bool:
    """Tell whether he was served, and the server neither grew nor complained."""
    return (
        honest.failure is None
        and len(honest.seconds) >= 10
        and honest.p95_ms < 1000.0
        and served.memory_mb - before_mb < most_mb
        and served.said == ""
    )


@row(
    "Pages of other sites, false names, no token",
    Guard(
        file="kneeviz/server/gate.py",
        function="Gate.refusal",
        line='if not all(self._is_own_page(origin, here) for origin in headers.get_all("Origin")):',
        instead="if False:",
        test="tests/hardening/test_gate.py -k another_site",
    ),
)
def strangers(scale: Scale) -> Outcome:
    """Ask for the state as a page of another site, under a false name, without the token."""
    count, refused = scale.count(1000), 0
    with serving("--token") as served:
        path = served.url.partition(str(served.port))[2]
        kinds = (
            {"path": path, "headers": {"Origin": "http://evil.example"}},
            {"path": path, "headers": {"Origin": "null"}},
            {"path": "/?token=wrong-but-long-enough"},
            {"headers": {"Cookie": f"kneeviz-{served.port}=wrong-but-long-enough"}},
        )
        for number in range(count):
            try:
                WebSocketClient(served.port, **kinds[number % len(kinds)]).close()
            except InvalidStatus as refusal:
                refused += refusal.response.status_code == 403
        with WebSocketClient(served.port, path=path) as own:
            own.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
    return Outcome(
        injected=f"{count:,} requests",
        happened=f"{refused:,} refused with 403 before any state was sent; its own page let in",
        sound=refused == count,
    )


@row(
    "Malformed, oversized, out-of-order, hostile messages",
    Guard(
        file="kneeviz/server/front.py",
        function="Connection.recv",
        line="if message is not None and self._joined.is_set():",
        instead="if True:",
        test="tests/hardening/test_wire.py -k hostile_messages",
    ),
)
def messages(scale: Scale) -> Outcome:
    """Send what no page would, over four connections at once."""
    with serving() as served, Honest(served.port) as honest:
        before = served.memory_mb
        sent = attacks.fuzz(served.port, scale.seconds, at_once=4)
        happened, sound = told(honest, served, before), fared_well(honest, served, before)
    return Outcome(
        injected=f"{sent:,} messages in {scale.seconds:.0f} s", happened=happened, sound=sound
    )


@row(
    "Half-open connections",
    Guard(
        file="kneeviz/server/caps.py",
        function="Crowd.enter",
        line="if len(self) >= self._limit:",
        instead="if False:",
        test="tests/hardening/test_wire.py -k half_open",
    ),
)
def half_open(scale: Scale) -> Outcome:
    """Hold three hundred connections that were begun and never finished."""
    count = 300
    with serving() as served, Honest(served.port) as honest:
        before, start = served.memory_mb, time.monotonic()
        with attacks.half_open(served.port, count):
            came = 0
            while time.monotonic() - start < scale.seconds:
                with WebSocketClient(served.port) as newcomer:
                    newcomer.wait(lambda c: c.counts.get("ReplayDoneMessage"), 10)
                    came += 1
                time.sleep(1.0)
        happened, sound = told(honest, served, before), fared_well(honest, served, before)
    return Outcome(
        injected=f"{count} for {scale.seconds:.0f} s",
        happened=f"{came} newcomers got in meanwhile; {happened}",
        sound=sound and came > 0,
    )


@row(
    "Visitors who never read, read slowly, or send a byte at a time",
    Guard(
        file="kneeviz/server/front.py",
        function="Connection.send",
        line="if self._told > FREE_FRAMES and not self._joined.is_set():",
        instead="if False:",
        test="tests/hardening/test_wire.py -k then_little",
    ),
)
def stalled(scale: Scale) -> Outcome:
    """Hold visitors who read nothing, others who read little, and who send a byte at a time."""
    with (
        serving() as served,
        Honest(served.port) as honest,
        attacks.stalled(served.port, 32),
        attacks.slow(served.port, 8) as read,
    ):
        before, start = served.memory_mb, time.monotonic()
        while time.monotonic() - start < scale.seconds:
            attacks.trickle(served.port, scale.seconds, count=20)
        happened, sound = told(honest, served, before), fared_well(honest, served, before)
        sound = sound and min(read) > 0
    injected = f"32, 8 and 20, for {scale.seconds:.0f} s"
    return Outcome(injected=injected, happened=happened, sound=sound)


@row(
    "Files made to keep a parser busy",
    Guard(
        file="kneeviz/jobs/uploads.py",
        function="Uploads._read",
        line="return Uploaded(told, client_id, parse_apart(name, content), None)",
        instead="return Uploaded(told, client_id, parse(name, content), None)",
        test="tests/viz/test_uploads.py -k slow_parser",
    ),
)
def long_files(scale: Scale) -> Outcome:
    """Let four visitors upload the worst files of the largest size, one after the other."""
    with serving() as served, Honest(served.port) as honest:
        before, end = served.memory_mb, time.monotonic() + scale.seconds
        files, counts = attacks.long_files(), [0, 0]

        def load(visitor: int) -> None:
            with WebSocketClient(served.port) as client:
                client.wait(lambda c: c.counts.get("ReplayDoneMessage"), 30)
                turn = 0
                while time.monotonic() < end:
                    name, content = files[(visitor + turn) % len(files)]
                    attacks.send_file(client, name, content, turn)
                    turn += 1
                    counts[0] += 1
                    client.wait(lambda c, n=turn: len(c.notifications) >= n, 60)
                    counts[1] += 1

        threads = [threading.Thread(target=load, args=(n,), daemon=True) for n in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(scale.seconds + 90)
        time.sleep(1.0)
        happened, sound = told(honest, served, before), fared_well(honest, served, before)
    return Outcome(
        injected=f"{counts[0]} files by 4 visitors in {scale.seconds:.0f} s",
        happened=f"{counts[1]} refused in a line; {happened}",
        sound=sound and counts[0] == counts[1],
    )


@row(
    "Unfinished uploads",
    Guard(
        file="kneeviz/viser_internals.py",
        function="crowding_fault",
        line="if len(own) >= _PENDING or sum(own) + size_bytes > _PENDING_BYTES:",
        instead="if False:",
        test="tests/hardening/test_wire.py -k few_under_way",
    ),
)
def uploads(scale: Scale) -> Outcome:
    """Begin uploads of the largest size and never finish one."""
    visitors = scale.count(60)
    with serving() as served, Honest(served.port) as honest:
        before = served.memory_mb

        def begin() -> None:
            with WebSocketClient(served.port) as client:
                attacks.begin_uploads(client, 5)

        threads = [threading.Thread(target=begin, daemon=True) for _ in range(visitors)]
        for number, thread in enumerate(threads):
            thread.start()
            if number % 6 == 5:
                thread.join(60)
        most = served.memory_mb
        for thread in threads:
            thread.join(60)
        most = max(most, served.memory_mb)
        time.sleep(1.0)
        # What was freed stays with the process for a while: a fifth of all that was sent.
        happened = told(honest, served, before)
        sound = fared_well(honest, served, before, most_mb=300.0)
    return Outcome(
        injected=f"{5 * visitors} of 5 MB by {visitors} visitors",
        happened=f"at most {most - before:.0f} MB held; {happened}",
        sound=sound,
    )


@row(
    "Visitors who leave before they have come",
    Guard(
        file="kneeviz/server/seats.py",
        function="Seats.join",
        line="if len(self._seats) >= self._limit:",
        instead="if False:",
        test="tests/hardening/test_leavers.py -k burst",
    ),
)
def leavers(scale: Scale) -> Outcome:
    """Let visitors of a server with a knee for each join and go within 40 ms."""
    app = App(port=0, shared=False)
    try:
        watchdog = Watchdog(app)
        got_in = hail_of_leavers(app.server.get_port(), scale.count(2000))
        end = time.monotonic() + 30
        while time.monotonic() < end and (len(app.seats) or watchdog.alive):
            time.sleep(0.05)
        left, most = max(len(app.seats), watchdog.alive), watchdog.most
        with WebSocketClient(app.server.get_port()):
            while time.monotonic() < end and not app.sessions:
                time.sleep(0.05)
            seated = len(app.sessions)
    finally:
        app.stop()
    return Outcome(
        injected=f"{got_in:,} visitors, gone within 40 ms",
        happened=f"{left} sessions left behind, at most {most} of {MAX_SESSIONS} at once; "
        f"the next visitor {'got his knee' if seated else 'found no place'}",
        sound=left == 0 and most <= MAX_SESSIONS and seated == 1,
    )
