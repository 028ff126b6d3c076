"""No modules of the package import each other in a circle, also not for types or inside of functions."""

import ast
from collections.abc import Mapping

from conftest import ROOT

PACKAGE = ROOT / "api/python/src/revprio"


def imported(text: str, names: set[str]) -> set[str]:
    """Returns the modules of the package that a source imports; a name of the package itself is one of `__init__`."""
    found = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            module = f"revprio.{node.module or ''}".rstrip(".") if node.level else str(node.module)
            found |= {f"{module}.{alias.name}" if module == "revprio" else module for alias in node.names}
    parts = {path.split(".")[1] if "." in path else "__init__" for path in found if path.split(".")[0] == "revprio"}
    return {part if part in names else "__init__" for part in parts if part != "_native"}


def in_circles(sources: Mapping[str, str]) -> list[str]:
    """Returns the modules that import themselves through others."""
    graph = {name: imported(text, set(sources)) for name, text in sources.items()}

    def reaches_itself(start: str) -> bool:
        seen: set[str] = set()
        waiting = [start]
        while waiting:
            for module in graph[waiting.pop()]:
                if module == start:
                    return True
                if module not in seen:
                    seen.add(module)
                    waiting.append(module)
        return False

    return sorted(filter(reaches_itself, graph))


def test_no_modules_import_each_other_in_a_circle() -> None:
    sources = {path.stem: path.read_text(encoding="utf-8") for path in PACKAGE.glob("*.py")}
    assert {"controller", "client", "models"} <= imported(sources["__init__"], set(sources))
    assert in_circles(sources) == []


def test_an_added_circle_is_found() -> None:
    line = {
        "__init__": "from revprio.a import A",
        "a": "from revprio import b",
        "b": "import revprio.c",
        "c": "import json",
    }
    assert in_circles(line) == []
    for text in (
        "from revprio.a import A",
        "from .a import A",
        "from . import a",
        "def f() -> None:\n    from revprio.a import A",
        "if TYPE_CHECKING:\n    import revprio.a",
    ):
        assert in_circles({**line, "c": text}) == ["a", "b", "c"], text
    assert in_circles({**line, "c": "from revprio import A"}) == ["__init__", "a", "b", "c"]
