"""List the licences of kneecore and all that it and its tests need: ``python tests/licences.py``.

Exit code 1 if one of them names no licence, or one that would bind kneecore's users (GPL, AGPL).
"""

import re
import sys
from importlib import metadata

BINDING = re.compile(r"\bA?GPL|(?<!Lesser )General Public License", re.IGNORECASE)


def needed(root="kneecore"):
    """Return the installed distributions that `root` and its tests need, itself first.

    All extras but the root's `test` are left out.
    """
    found, waiting, of_tests = {}, [root], re.compile(r"""extra == ["']test["']""")
    while waiting:
        name = re.sub(r"[-_.]+", "-", waiting.pop(0)).lower()
        if name in found:
            continue
        try:
            found[name] = metadata.distribution(name)
        except metadata.PackageNotFoundError:  # for another platform or Python
            continue
        for line in found[name].requires or ():
            requirement, _, marker = line.partition(";")
            if "extra" not in marker or (len(found) == 1 and of_tests.search(marker)):
                waiting.append(re.match(r"[\w.-]+", requirement)[0])
    return list(found.values())


def licence(distribution):
    """Return the licence that a distribution names, or an empty text."""
    about = distribution.metadata
    classified = [
        line.rpartition("::")[2].strip()
        for line in about.get_all("Classifier") or ()
        if line.startswith("License ::")
    ]
    stated = about.get("License-Expression") or "; ".join(classified) or about.get("License")
    stated = (stated or packed_licence(distribution)).strip()
    return stated.splitlines()[0] if stated else ""


def packed_licence(distribution):
    """Return the text of the licence that comes with a distribution, or an empty text."""
    for name in distribution.metadata.get_all("License-File") or ():
        text = distribution.read_text(f"licenses/{name}") or distribution.read_text(name)
        if text:
            return text
    return ""


def main():
    faults = 0
    for distribution in needed():
        stated = licence(distribution)
        faults += not stated or bool(BINDING.search(stated))
        print(f"{distribution.name:24} {distribution.version:16} {stated or 'NONE'}")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
