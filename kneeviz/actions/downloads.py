"""What goes out as files and what comes in: bytes to objects and back, no widgets."""

import io
import tempfile
import zipfile
from pathlib import Path
from typing import Any

from kneecore import FileFormatError, Knee
from kneecore.knee.file import parse_knee
from kneecore.search.result import SearchResult


def read_upload(name: str, content: bytes) -> Knee | SearchResult:
    """Return the knee (TOML) or the result (JSON) in an uploaded file.

    The content decides, not the name, which comes from outside.

    Raises
    ------
    FileFormatError
        If it is neither, with the reason.
    """
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError:
        raise FileFormatError("not a text file in UTF-8") from None
    if text.lstrip().startswith(("{", "[")) and not _looks_like_toml(text):
        return SearchResult.from_json(text)
    if name.lower().endswith(".json"):
        return SearchResult.from_json(text)
    return parse_knee(text)


def _looks_like_toml(text: str) -> bool:
    # A table's header, "[parameters...]", also starts with a bracket.
    first = text.lstrip().splitlines()[0].strip()
    return first.startswith("[") and first.endswith("]") and not first.startswith(("[{", '["'))


def everything(result: SearchResult) -> bytes:
    """Return all files of a result, figures and (where needed) its knee included, as a ZIP."""
    packed = io.BytesIO()
    with (
        tempfile.TemporaryDirectory() as folder,
        zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive,
    ):
        for path in result.save(folder, force=True):
            archive.write(path, Path(path).name)
    return packed.getvalue()


def result_files(result: SearchResult, name: str) -> bytes:
    """Return the content of a download of a result: `result.json`, `curves.csv` or `result.zip`."""
    makers: dict[str, Any] = {
        "result.json": lambda: result.to_json().encode(),
        "curves.csv": lambda: result.curves_csv().encode(),
        "result.zip": lambda: everything(result),
    }
    content: bytes = makers[name]()
    return content
