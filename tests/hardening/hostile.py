"""Messages that no page would send. Seeded: the same seed sends the same."""

import dataclasses
import math
import random
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
from viser import _messages
from viz.websocket_client import CAMERA

ODD: tuple[Any, ...] = (
    math.nan, math.inf, -math.inf, 1e300, -1e300, 2**63, -(2**63), "", "x" * 5000, "\x00\x1b[2J",
    "<script>alert(1)</script>", b"", b"\xff" * 3000, None, [], {}, [[[]]], {"value": {}},
    [1e300] * 2000, "__class__", -0.5e-300,
)  # fmt: skip
"""Values that no widget of ours takes."""
KINDS = sorted(kind.__name__ for kind in _messages.Message.get_subclasses())


def _packed(message: Any) -> bytes:
    return msgspec.msgpack.encode(message)


def _random_bytes(rng: random.Random, _: list[str]) -> bytes:
    return rng.randbytes(rng.randrange(300))


def _nested(rng: random.Random, _: list[str]) -> bytes:
    deep = rng.choice([b"\x91", b"\x81\xa1a"]) * rng.choice([100, 2000, 60_000]) + b"\xc0"
    return rng.choice([b"", b"\x82\xa4type\xb0GuiUpdateMessage\xa4uuid"]) + deep


def _oversized(rng: random.Random, _: list[str]) -> bytes:
    size = rng.choice([100_000, 600_000, 700_000, 3_000_000])
    return _packed({"type": "GuiUpdateMessage", "uuid": "a", "updates": {"value": "x" * size}})


def _flipped(rng: random.Random, _: list[str]) -> bytes:
    strange = {"type": "GuiUpdateMessage", "uuid": "nobody", "updates": {"value": 0.5}}
    raw = bytearray(_packed(rng.choice([CAMERA, strange, _start(rng, []), _part(rng, [])])))
    for _ in range(rng.randrange(1, 6)):
        raw[rng.randrange(len(raw))] ^= 1 << rng.randrange(8)
    return bytes(raw[: rng.randrange(1, len(raw) + 1)] if rng.random() < 0.3 else raw)


def _any_kind(rng: random.Random, widgets: list[str]) -> bytes:
    """Any message that viser knows, also those that only a server sends, with odd fields."""
    name = rng.choice([kind for kind in KINDS if kind != "GuiUpdateMessage"])
    names = [f.name for f in dataclasses.fields(getattr(_messages, name))]
    fields = {name: rng.choice([*ODD, *widgets]) for name in names}
    return _packed({"type": name} | fields)


def _odd_camera(rng: random.Random, _: list[str]) -> bytes:
    return _packed(CAMERA | {rng.choice(sorted(CAMERA)): rng.choice(ODD)})


def _odd_value(rng: random.Random, widgets: list[str]) -> bytes:
    uuid = rng.choice(widgets) if widgets else "nobody"
    return _packed(
        {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": rng.choice(ODD)}}
    )


def _odd_attribute(rng: random.Random, widgets: list[str]) -> bytes:
    names = (
        "uuid",
        "disabled",
        "min",
        "max",
        "visible",
        "__class__",
        "update_cb",
        "_impl",
        "x" * 99,
    )
    updates = {name: rng.choice(ODD) for name in rng.sample(names, 2)}
    uuid = rng.choice([*widgets, "nobody"])
    return _packed({"type": "GuiUpdateMessage", "uuid": uuid, "updates": updates})


def _start(rng: random.Random, widgets: list[str]) -> dict[str, Any]:
    return {
        "type": "FileTransferStartUpload",
        "source_component_uuid": rng.choice([*widgets, "nobody"]),
        "transfer_uuid": f"t{rng.randrange(20)}",
        "filename": rng.choice(["a.toml", "../../x", "", "\x1b[2J", "x" * 2000]),
        "mime_type": "text/plain",
        "part_count": rng.choice([0, 1, 2, 64, 65, -1, 2**40, 1.5]),
        "size_bytes": rng.choice([0, 1, 10, 5_000_000, 5_000_001, -1, 2**62, math.nan]),
    }


def _part(rng: random.Random, _: list[str]) -> dict[str, Any]:
    return {
        "type": "FileTransferPart",
        "source_component_uuid": rng.choice(["nobody", None]),
        "transfer_uuid": f"t{rng.randrange(20)}",
        "part_index": rng.choice([0, 1, 63, -1, 2**40]),
        "content": rng.randbytes(rng.choice([0, 1, 10, 2000, 100_000])),
    }


def _upload(rng: random.Random, widgets: list[str]) -> bytes:
    return _packed(rng.choice([_start, _part])(rng, widgets))


MAKERS: tuple[Callable[[random.Random, list[str]], bytes], ...] = (
    _random_bytes, _nested, _oversized, _flipped, _any_kind, _odd_camera, _odd_value,
    _odd_attribute, _upload,
)  # fmt: skip


def hostile_messages(seed: int, widgets: list[str]) -> Iterator[bytes]:
    """Yield hostile messages without end; `widgets` are ids that exist."""
    rng = random.Random(seed)
    while True:
        # Oversized ones end the connection, so they are rare.
        maker = rng.choice(MAKERS)
        if maker is not _oversized or rng.random() < 0.1:
            yield maker(rng, widgets)
