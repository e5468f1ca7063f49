"""Where the packaged data files are, in a wheel and in a checkout alike."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def asset_path(name: str) -> Path:
    """Return the path of the packaged data file `name`.

    A wheel carries the files inside the package (``kneecore/assets``); a checkout keeps them in
    the top-level ``assets`` folder.

    Raises
    ------
    FileNotFoundError
        If neither place has the file.
    """
    for folder in (_PACKAGE / "assets", _PACKAGE.parent / "assets"):
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"the packaged file {name!r} is missing; reinstall kneecore")
