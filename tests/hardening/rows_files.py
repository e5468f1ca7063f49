"""Rows of files: results and knee files with something wrong in them."""

import json
import random
import tempfile
from pathlib import Path

import every_kind
from hardening.rows import Guard, Outcome, Scale, row

from kneecore import KneecoreError, ParameterSpace, load
from kneecore.files.digest import digest_of
from kneecore.files.folder import to_json
from kneecore.knee.file import dump_knee, parse_knee

_VALUES = (
    *(None, True, False, -1, 0, 1.5, 1e300, -1e300, 10**30, "", "x", "\x1b[31m", [], {}, [[]]),
    *([None], {"a": 1}),
)


def _places(value, path=()):
    yield path
    entries = value.items() if isinstance(value, dict) else ()
    if isinstance(value, list):
        entries = enumerate(value)
    for key, one in entries:
        yield from _places(one, (*path, key))


def _bytes_changed(text, rng):
    content = bytearray(text.encode())
    for _ in range(rng.randint(1, 8)):
        at = rng.randrange(len(content))
        kind = rng.randrange(3)
        if kind == 0:
            content[at] = rng.randrange(256)
        elif kind == 1:
            del content[at : at + rng.randint(1, 40)]
        else:
            content[at:at] = content[at : at + rng.randint(1, 40)]
    return bytes(content[: rng.choice((None, None, len(content) // 2))])


def _document_changed(text, rng):
    document = json.loads(text)
    *above, last = rng.choice([p for p in _places(document) if p])
    table = document
    for key in above:
        table = table[key]
    kind = rng.randrange(4)
    if kind == 0:
        del table[last]
    elif kind == 1 and isinstance(table[last], int | float):
        table[last] = table[last] * rng.choice((-1, 0.001, 1.001, 1000))
    elif kind == 2 and isinstance(table, dict):
        table[rng.choice(("n_more", "seconds", "x", "schema"))] = rng.choice(_VALUES)
    else:
        table[last] = rng.choice(_VALUES)
    told = rng.randrange(3)  # the digest kept, left out, or made to fit
    if told:
        document.pop("digest", None)
    if told == 2:
        document["digest"] = digest_of(document)
    return json.dumps(document).encode()


def _same_again(read, content):
    """Tell whether a result that was read is saved as what it was read from."""
    if not hasattr(read, "to_dict"):
        return False
    again = json.loads(to_json(read.to_dict()))
    document = json.loads(content)
    skipped = ("digest", "title", "flexion_at_rest_deg")  # a response's title is no result
    return _within({k: v for k, v in document.items() if k not in skipped}, again)


def _within(said, again):
    """Tell whether all that a file said is said again; what it left out may be added."""
    if isinstance(said, dict) and isinstance(again, dict):
        return all(key in again and _within(one, again[key]) for key, one in said.items())
    if isinstance(said, list) and isinstance(again, list):
        return len(said) == len(again) and all(map(_within, said, again))
    if isinstance(said, int | float) and isinstance(again, int | float):
        return abs(said - again) <= 2e-8 * max(1.0, abs(said))
    return said == again


def _try_result(path, text, rng):
    """Return 'refused', 'read', or what is wrong."""
    change = rng.choice((_bytes_changed, _document_changed, _document_changed))
    content = change(text, rng)
    path.write_bytes(content)
    try:
        read = load(path)
    except KneecoreError as error:
        return "refused" if "\n" not in str(error) else f"two lines: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    if _denied_by_its_digest(content):
        return "read though its digest does not match"
    return "read" if _same_again(read, content) else "saved as something else"


def _denied_by_its_digest(content):
    document = json.loads(content)
    said = document.pop("digest", None)
    return said is not None and said != digest_of(document)


def _try_knee(text, rng):
    content = _bytes_changed(text, rng)
    try:
        knee = parse_knee(content)
        again = parse_knee(
            dump_knee(baseline=knee.baseline, half_ranges=knee.half_ranges, title=knee.title)
        )
    except KneecoreError as error:
        return "refused" if "\n" not in str(error) else f"two lines: {error}"
    except Exception as error:
        return f"{type(error).__name__}: {error}"
    return "read" if (again.baseline == knee.baseline).all() else "saved as something else"


@row(
    "Result and knee files changed at random",
    Guard(
        file="kneecore/files/digest.py",
        function="check_digest",
        line="if said != follows:",
        instead="if False:",
        test="tests/hardening/test_files.py",
    ),
)
def mutated_files(scale: Scale) -> Outcome:
    """Change bytes, values and structure; each is refused in a line or is what it says."""
    rng, n = random.Random(0), scale.count(1000)
    texts = list(every_kind.texts().values())
    knee = ParameterSpace().to_toml()
    came_of: dict[str, int] = {}
    with tempfile.TemporaryDirectory() as folder:
        for i in range(n):
            if i % 4 == 3:
                what = _try_knee(knee, rng)
            else:
                what = _try_result(Path(folder) / "one.json", texts[i % len(texts)], rng)
            came_of[what] = came_of.get(what, 0) + 1
    refused, read = came_of.pop("refused", 0), came_of.pop("read", 0)
    wrong = "; ".join(f"{count} x {what}" for what, count in came_of.items())
    return Outcome(
        injected=f"{n:,} files with changed bytes, values and structure",
        happened=f"{refused:,} refused in a line, {read:,} read as what they say, "
        + (wrong or "no traceback"),
        sound=not came_of,
    )
