"""Who imports whom, read from the files' syntax trees: nothing is run, typed imports count too."""

import ast
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("kneecore", "kneeviz")


class Import(NamedTuple):
    """One import as it stands in a file."""

    modules: tuple[str, ...]
    """What it may mean, the most special first: ``from a import b`` is `a.b` or `a`."""
    line: int
    in_function: bool


def sources(root: Path = ROOT, endings: tuple[str, ...] = (".py",)) -> list[Path]:
    """Return the files of both packages."""
    return sorted(p for name in PACKAGES for e in endings for p in (root / name).rglob(f"*{e}"))


def module_of(path: Path, root: Path) -> str:
    """Return a file's module; a package, its `__init__` and the stub of that are one."""
    parts = path.relative_to(root).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def is_import_module(node: ast.AST) -> bool:
    """Tell whether a node calls `import_module` or `__import__`, however it came to that name."""
    if not isinstance(node, ast.Call):
        return False
    name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
    return name in ("import_module", "__import__")


def _meant(node: ast.AST, package: list[str]) -> list[tuple[str, ...]]:
    """Return what a node imports, as `Import.modules`; `package` is what the file is in."""
    if isinstance(node, ast.Import):
        return [(alias.name,) for alias in node.names]
    if isinstance(node, ast.ImportFrom):
        above = package[: len(package) - node.level + 1] if node.level else []
        base = ".".join([*above, *([node.module] if node.module else [])])
        return [(f"{base}.{alias.name}", base) for alias in node.names]
    if is_import_module(node):
        given = node.args[0] if node.args else None
        return [(given.value,) if isinstance(given, ast.Constant) else ()]
    return []


def _walk(node: ast.AST, in_function: bool = False) -> Iterator[tuple[ast.AST, bool]]:
    for child in ast.iter_child_nodes(node):
        yield child, in_function
        inside = isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        yield from _walk(child, in_function or inside)


def imports_of(path: Path, root: Path = ROOT) -> Iterator[Import]:
    """Yield all imports of a file, wherever they stand."""
    package = list(path.parent.relative_to(root).parts)
    for node, in_function in _walk(ast.parse(path.read_text(encoding="utf-8"))):
        for modules in _meant(node, package):
            yield Import(modules, node.lineno, in_function)


def arrows(root: Path = ROOT) -> set[tuple[str, str]]:
    """Return (importer, imported) over the modules of both packages."""
    files = sources(root, (".py", ".pyi"))
    known = {module_of(path, root) for path in files}
    found = set()
    for path in files:
        importer = module_of(path, root)
        for one in imports_of(path, root):
            imported = next((m for m in one.modules if m in known), None)
            if imported is not None and imported != importer:
                found.add((importer, imported))
    return found


def circles(edges: set[tuple[str, str]]) -> list[set[tuple[str, str]]]:
    """Return the arrows of each group of modules that can all be reached from one another."""
    names = sorted({name for edge in edges for name in edge})
    place = {name: k for k, name in enumerate(names)}
    rows, columns = ([place[edge[end]] for edge in edges] for end in (0, 1))
    graph = csr_array((np.ones(len(edges)), (rows, columns)), shape=(len(names), len(names)))
    _, group = connected_components(graph, connection="strong")
    within: dict[int, set[tuple[str, str]]] = {}
    for start, end in edges:
        if group[place[start]] == group[place[end]]:
            within.setdefault(int(group[place[start]]), set()).add((start, end))
    return list(within.values())
