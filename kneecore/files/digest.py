"""The digest of a result's content, by which a file that was changed afterwards is known."""

import hashlib
import json
from typing import Any

from kneecore.errors import FileFormatError

__all__ = ["DIGEST", "check_digest", "digest_of", "with_digest"]

DIGEST = "digest"


def digest_of(document: dict[str, Any]) -> str:
    """Return the SHA-256 of a document without its digest.

    Its text is JSON with sorted keys, no spaces and no escapes but those that JSON needs, in UTF-8:
    neither the order of keys nor the layout of a file counts.
    """
    content = {key: value for key, value in document.items() if key != DIGEST}
    text = json.dumps(
        content, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
    )
    return f"sha256:{hashlib.sha256(text.encode()).hexdigest()}"


def with_digest(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document with its digest, the last of its keys."""
    return document | {DIGEST: digest_of(document)}


def check_digest(document: dict[str, Any]) -> None:
    """Raise a `FileFormatError` if the digest is not that of the document.

    A document without one is from an earlier version or made by hand, and passes.
    """
    if DIGEST not in document:
        return
    said, follows = document[DIGEST], digest_of(document)
    if said != follows:
        raise FileFormatError(
            f"`{DIGEST}` is {str(said)[:20]!r}..., but the content has {follows[:20]!r}...: it was "
            "changed after it was written"
        )
