"""Writes src/revprio/aio.py: the blocking client, its controllers and its simulations for asyncio.

python generate_aio.py | ruff format - > src/revprio/aio.py

Every method waits that calls the service, and every call of such a method is awaited. A constructor cannot wait, so
`async with` opens what the blocking constructor opens.
"""

import ast
import copy
import sys
from pathlib import Path

SOURCES = Path(__file__).parent / "src/revprio"

CLASSES = {
    "AsyncClient": ["client.Client", "calls.Calls"],
    "AsyncController": ["remote.RemoteController", "controller.Controller.change"],
    "AsyncSession": ["remote.Session"],
    "AsyncStateless": ["remote.Stateless"],
    "AsyncStream": ["remote.Stream"],
    "AsyncSimulationRun": ["simulations.SimulationRun"],
}
"""Each class with the classes and methods that it is made from."""

TEXT = '"""The asyncio version of `{}`, with the same methods and arguments; use it with `async with`."""'

NAMES = {
    "Calls": "AsyncClient", "Caller": "AsyncClient", "Client": "AsyncClient", "Connector": "AsyncClient",
    "RemoteController": "AsyncController", "Session": "AsyncSession", "SimulationRun": "AsyncSimulationRun",
    "Stateless": "AsyncStateless", "Stream": "AsyncStream",
    "AbstractContextManager": "AbstractAsyncContextManager", "ExitStack": "AsyncExitStack",
    "receive": "receive_async",
    "__enter__": "__aenter__", "__exit__": "__aexit__", "_open": "open",
}  # fmt: skip
"""Names with another name in asyncio."""

CALLS = {
    "time.sleep": "asyncio.sleep", "httpx.Client": "httpx.AsyncClient", "self._http.close": "self._http.aclose",
    "self._exit.enter_context": "self._exit.enter_async_context", "self._exit.close": "self._exit.aclose",
}  # fmt: skip
"""Functions of other packages with another name in asyncio."""

WAITING = {"asyncio.sleep", "receive_async", "self._exit.aclose", "self._exit.enter_async_context", "self._http.aclose",
           "self._http.send", "self._socket.send"}  # fmt: skip
"""Functions of other packages that are awaited."""

IMMEDIATE = {"__init__", "_connections", "connect", "session", "stateless", "stream"}
"""Methods that return at once: what they return waits."""

BASES = {"AsyncController": "ABC"}
"""Classes with another base than their source."""

REPLACED_IMPORTS = {"websockets.sync.client": "websockets.asyncio.client"}
HEADER = '"""The client for asyncio: `async with AsyncClient(url) as client: answer = await client.resolve(…)`.\n\n' \
         'Generated from the blocking client by `generate_aio.py`; do not edit.\n"""'  # fmt: skip

Function = ast.FunctionDef | ast.AsyncFunctionDef


def parse(module: str) -> ast.Module:
    """Reads a module of the package."""
    return ast.parse((SOURCES / f"{module}.py").read_text(encoding="utf-8"))


def members(path: str) -> tuple[list[ast.stmt], list[ast.expr]]:
    """Returns the members of a class, or one of its methods; and the bases of the class."""
    module, name, *method = path.split(".")
    classes = [node for node in parse(module).body if isinstance(node, ast.ClassDef) and node.name == name]
    found = [
        node for node in classes[0].body if not method or (isinstance(node, ast.FunctionDef) and node.name in method)
    ]
    return found, [] if method else classes[0].bases


def is_property(node: ast.stmt) -> bool:
    """Returns whether a member is a property."""
    return isinstance(node, ast.FunctionDef) and any(ast.unparse(item) == "property" for item in node.decorator_list)


class Waiting(ast.NodeTransformer):
    """Renames, and awaits the calls of methods that wait."""

    def __init__(self, methods: set[str]) -> None:
        """`methods`: names of the methods that wait."""
        self.methods = methods

    def visit_Name(self, node: ast.Name) -> ast.expr:
        """Renames a name."""
        return ast.Name(NAMES.get(node.id, node.id), node.ctx)

    def visit_Attribute(self, node: ast.Attribute) -> ast.expr:
        """Renames an attribute or a function of another package."""
        text = ast.unparse(node)
        if text in CALLS:
            return ast.parse(CALLS[text], mode="eval").body
        return ast.Attribute(self.visit(node.value), NAMES.get(node.attr, node.attr), node.ctx)

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Awaits a call that waits."""
        self.generic_visit(node)
        text = ast.unparse(node.func)
        owner, _, method = text.rpartition(".")
        is_own = owner in ("self", "self._client", "self._session") and method in self.methods
        return ast.Await(node) if is_own or text in WAITING else node


def opens(node: ast.stmt) -> bool:
    """Returns whether a statement is `self._open()`."""
    return isinstance(node, ast.Expr) and ast.unparse(node) == "self._open()"


def method(source: ast.FunctionDef, methods: set[str], *, is_controller: bool) -> Function:
    """Returns the method of the asyncio class."""
    node = copy.deepcopy(source)
    node.body = [statement for statement in node.body if node.name != "__init__" or not opens(statement)]
    if node.name == "__enter__" and is_controller:
        node.body[:1] = ast.parse('"""Starts the controller."""\nself._open()').body
    Waiting(methods).visit(node)
    node.name = NAMES.get(node.name, node.name)
    if source.name in IMMEDIATE or is_property(source):
        return node
    waiting = ast.AsyncFunctionDef(node.name, node.args, node.body, node.decorator_list, node.returns)
    return ast.copy_location(waiting, node)


def asynchronous_methods() -> set[str]:
    """Returns the new names of all methods that wait."""
    sources = [node for parts in CLASSES.values() for part in parts for node in members(part)[0]]
    functions = [node for node in sources if isinstance(node, ast.FunctionDef) and not is_property(node)]
    return {NAMES.get(node.name, node.name) for node in functions} - IMMEDIATE


def asynchronous_class(name: str, parts: list[str], methods: set[str]) -> ast.ClassDef:
    """Returns a class. Of two methods of one name, the first one counts: it overrides the other one."""
    body: dict[str, ast.stmt] = {}
    bases: list[ast.expr] = []
    for part in parts:
        found, inherited = members(part)
        bases = bases or inherited
        for place, node in enumerate(found):
            if isinstance(node, ast.FunctionDef):
                body.setdefault(node.name, method(node, methods, is_controller=name == "AsyncController"))
            elif place > 0:
                body[f"{part} {place}"] = Waiting(methods).visit(copy.deepcopy(node))
    base = BASES.get(name) or ", ".join(NAMES.get(ast.unparse(base), ast.unparse(base)) for base in bases)
    node = ast.parse(
        f"class {name}({'' if base == name else base}):\n    {TEXT.format(name.removeprefix('Async'))}"
    ).body[0]
    assert isinstance(node, ast.ClassDef)
    node.body += body.values()
    return node


def sources() -> list[str]:
    """Returns the modules that the classes come from."""
    return list(dict.fromkeys(part.split(".")[0] for parts in CLASSES.values() for part in parts))


def imports(used: set[str]) -> list[str]:
    """Returns the imports of the sources whose names are used, and of the other names of the sources."""
    lines = {
        "import asyncio", "from abc import ABC, abstractmethod", "from typing import TypeVar",
        "from revprio.async_drive import drive",
    }  # fmt: skip
    names: dict[str, set[str]] = {}
    for module in sources():
        tree = parse(module)
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                lines |= {f"import {alias.name}" for alias in node.names if alias.name in used}
            elif isinstance(node, ast.ImportFrom) and node.module not in ("__future__", "abc"):
                source = REPLACED_IMPORTS.get(str(node.module), str(node.module))
                given = {NAMES.get(alias.name, alias.name) for alias in node.names}
                names.setdefault(source, set()).update(given & used)
        functions = {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}
        values = [node for node in tree.body if isinstance(node, ast.Assign)]
        own = functions | {ast.unparse(target) for node in values for target in node.targets}
        names.setdefault(f"revprio.{module}", set()).update(own & used - {"A"})
    others = {module: sorted(given - set(CLASSES)) for module, given in names.items()}
    return sorted(lines | {f"from {module} import {', '.join(given)}" for module, given in others.items() if given})


def source() -> str:
    """Returns the source text of the module."""
    methods = asynchronous_methods()
    classes = [asynchronous_class(name, parts, methods) for name, parts in CLASSES.items()]
    used = {
        node.id
        for item in classes
        for node in ast.walk(item)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load)
    }
    texts = [ast.unparse(ast.fix_missing_locations(item)) for item in classes]
    names = ", ".join(f'"{name}"' for name in sorted([*CLASSES, "drive"]))
    head = [HEADER, "from __future__ import annotations", *imports(used), f"__all__ = [{names}]", 'A = TypeVar("A")']
    return "\n".join(head) + "\n\n\n" + "\n\n\n".join(texts) + "\n"


if __name__ == "__main__":
    sys.stdout.write(source())
