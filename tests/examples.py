"""The worked examples of docs/examples: run, compared with their pages, and written into them.

A page is Markdown beside the folder of its files. A block that names a file after its language
shows the file, or a part of it; ``text`` before ``study.py`` is what that prints.
``python tests/examples.py [NAME ...]`` runs them where they are: it writes their pictures and what
they print into the pages.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "docs" / "examples"
NAMES = tuple(sorted(page.stem for page in EXAMPLES.glob("*.md")))

_BLOCK = re.compile(r"^```(\w+) (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NUMBER = re.compile(r"[-+]?\d+(?:,\d{3})*(?:\.\d+)?")


def page(name):
    """Return an example's page."""
    return (EXAMPLES / f"{name}.md").read_text(encoding="utf-8")


def blocks(name):
    """Return (language, file, text) of each block of a page that names a file."""
    return [found.groups() for found in _BLOCK.finditer(page(name))]


def said(name):
    """Return what the page says that the example prints."""
    [text] = [text for language, file, text in blocks(name) if is_printed(language, file)]
    return text


def is_printed(language, file):
    """Tell whether a block shows what a script prints, and not the script."""
    return language == "text" and file.endswith(".py")


def number_after(words, text):
    """Return the number that follows these words, as it is printed."""
    return float(re.search(re.escape(words) + r"\s*([-+\d.]+\d)", text)[1])


def differences(expected, printed, share=0.005):
    """Return what differs: words, or numbers by more than a share and a unit of the last digit."""
    if _NUMBER.split(expected) != _NUMBER.split(printed):
        return [f"other words:\n{expected}\nprinted:\n{printed}"]
    pairs = zip(_NUMBER.findall(expected), _NUMBER.findall(printed), strict=True)
    return [f"{a} is printed as {b}" for a, b in pairs if not _close(a, b, share)]


def _close(a, b, share):
    digit = 10.0 ** -len(a.partition(".")[2])
    one, other = (float(text.replace(",", "")) for text in (a, b))
    return abs(one - other) <= share * abs(one) + 1.001 * digit


def pictures(name):
    """Return the files of the pictures that a page shows."""
    return re.findall(r"!\[[^]]*\]\((\S+?)\)", page(name))


def main(names):
    for name in names or NAMES:
        done = subprocess.run(
            [sys.executable, "study.py"],
            cwd=EXAMPLES / name, capture_output=True, text=True, check=True,
        )  # fmt: skip
        text = page(name).replace(said(name), done.stdout)
        (EXAMPLES / f"{name}.md").write_text(text, encoding="utf-8")
        print(f"{name}:\n{done.stdout}")


if __name__ == "__main__":
    main(sys.argv[1:])
