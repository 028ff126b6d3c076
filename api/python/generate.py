"""Writes src/revprio/models.py and problem.py: one pydantic model for each schema of the OpenAPI document.

python generate.py ../openapi.json problem | ruff format - > src/revprio/problem.py
python generate.py ../openapi.json models | ruff format - > src/revprio/models.py

A problem has a module of its own: the errors hold it, and a body of the models raises one of the errors.
"""

import json
import re
import sys
import textwrap
from collections.abc import Iterator
from pathlib import Path
from typing import Any

Schema = dict[str, Any]

# The class `Controller` of the client is a running controller; the schema of that name is its configuration.
NAMES = {"Controller": "ControllerConfig"}
# Python types of schemas that are arrays of numbers. `PerAxis_f64` is one number for all axes or one for each.
ARRAYS = {"PerAxis_f64": "ArrayLike", "JointVector": "JointVector"}
# What Python users have at hand, and the type of `revprio.conversions` that takes it.
BASES = {"Orientation": "Quaternion"}
CONSTANTS = {"Profile", "PostureTarget"}
FIELDS = {"RobotRegistrationUrdf": "UrdfText"}
NOTES = {
    "Orientation": "Four numbers in a list or an array are x, y, z, w, as in ROS and SciPy.",
    "Profile": "A number or an array is a constant.",
    "PostureTarget": "An array is a constant.",
}
SIMPLE = {"null": "None", "boolean": "bool", "integer": "int", "number": "float", "string": "str"}
HEADER = '''"""The bodies of requests and answers. Generated from the OpenAPI document by `generate.py`; do not edit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

from numpy.typing import ArrayLike as AnyArrayLike
from pydantic import BeforeValidator, Field

from revprio.answers import Answer
from revprio.bodies import (
    ArrayLike,
    Body,
    FloatArray,
    JointVector,
    LowerBounds,
    Matrix,
    OneOrMore,
    Tagged,
    UpperBounds,
    Vector,
)
from revprio.conversions import Quaternion, UrdfText, constant
from revprio.problem import REMEDIES, Problem
'''
PROBLEM_HEADER = '''"""A refused request. Generated from the OpenAPI document by `generate.py`; do not edit."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from revprio.answers import Answer
'''


class Models:
    """The source text of all models, each after the models that it uses."""

    def __init__(self, document: Schema) -> None:
        """Writes the models of all schemas of an OpenAPI document."""
        self.schemas: dict[str, Schema] = document["components"]["schemas"]
        for name, note in NOTES.items():
            self.schemas[name]["description"] += f" {note}"
        self.requests = self._reachable_from_requests(document)
        self.written: dict[str, str] = {}
        for name in self.schemas:
            self.reference(name)

    def _reachable_from_requests(self, document: Schema) -> set[str]:
        bodies = [
            operation["requestBody"]
            for item in document["paths"].values()
            for operation in item.values()
            if isinstance(operation, dict) and "requestBody" in operation
        ]
        found: set[str] = set()
        waiting = list(references(bodies))
        while waiting:
            name = waiting.pop()
            if name not in found:
                found.add(name)
                waiting.extend(references(self.schemas[name]))
        return found

    def reference(self, name: str) -> str:
        """Returns the Python name of a schema; writes its model first if it is missing."""
        if name in ARRAYS:
            return ARRAYS[name]
        python = NAMES.get(name) or re.sub("_(.)", lambda part: part[1].upper(), name)
        if python not in self.written:
            schema = self.schemas[name]
            if schema.get("type") == "object":
                self.model(python, schema, is_request=name in self.requests)
            else:
                kind = self.type(schema, python, is_request=name in self.requests)
                self.written[python] = f"{alias(python, kind)}\n{docstring(schema)}"
        return python

    def model(self, name: str, schema: Schema, *, is_request: bool) -> str:
        """Writes the class of an object schema; returns its name."""
        required = schema.get("required", [])
        tagged = is_tagged(schema)
        base = BASES.get(name) or ("Tagged" if tagged else "Body" if is_request else "Answer")
        lines = [f"class {name}({base}):"]
        fields = sorted(schema["properties"].items(), key=lambda item: item[0] not in required)
        lines += indented(class_docstring(schema, dict(fields)))
        for field, content in fields:
            kind = self.type(content, f"{name}{field.title()}", is_request=is_request)
            if field == "kind" and tagged:
                lines.append(f'    kind: {kind} = "{content["enum"][0]}"')
            elif field in required:
                lines.append(f"    {field}: {kind}")
            elif not is_request and content.get("type") == "array":
                lines.append(f"    {field}: {kind} = Field(default_factory=list)")
            else:
                lines.append(f"    {field}: {kind.removesuffix(' | None')} | None = None")
            lines += indented(docstring(content))
        self.written[name] = "\n".join(lines)
        return name

    def type(self, schema: Schema, name: str, *, is_request: bool) -> str:
        """Returns the annotation of a schema; `name` names a class for an inline object schema."""
        if "$ref" in schema:
            return self.reference(schema["$ref"].rsplit("/", 1)[1])
        if "enum" in schema:
            return f"Literal[{', '.join(json.dumps(word) for word in schema['enum'])}]"
        if "oneOf" in schema:
            return self.union(schema["oneOf"], name, is_request=is_request)
        kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
        options = [self.plain(kind, schema, name, is_request=is_request) for kind in kinds]
        return " | ".join(sorted(options, key="None".__eq__))

    def union(self, options: list[Schema], name: str, *, is_request: bool) -> str:
        """Returns the annotation of a union."""
        kinds = [self.type(option, f"Explicit{name}", is_request=is_request) for option in options]
        union = " | ".join(sorted(kinds, key="None".__eq__))
        return f'Annotated[{union}, Field(discriminator="kind")]' if all(map(is_tagged, options)) else union

    def numbers(self, name: str) -> str:
        """Returns the annotation of numbers in a request."""
        return "Matrix" if name.endswith("Jacobian") else "Vector"

    def schema_of(self, schema: Schema) -> Schema:
        """Returns the schema that a reference names, or the schema itself."""
        return self.schemas[schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else schema

    def plain(self, kind: str, schema: Schema, name: str, *, is_request: bool) -> str:
        """Returns the annotation of a schema with one JSON type."""
        if kind in SIMPLE:
            return FIELDS.get(name) or SIMPLE[kind]
        if kind == "array" and is_request and is_nullable(schema["items"]):
            return "LowerBounds" if name.endswith("Lower") else "UpperBounds"
        if kind == "array" and is_numeric(schema["items"]):
            return self.numbers(name) if is_request else "FloatArray"
        if kind == "array":
            items = self.type(schema["items"], name, is_request=is_request)
            return (
                f"OneOrMore[{items}]" if is_request and is_word(self.schema_of(schema["items"])) else f"list[{items}]"
            )
        if isinstance(schema.get("additionalProperties"), dict):
            return f"dict[str, {self.type(schema['additionalProperties'], name, is_request=is_request)}]"
        if "properties" in schema:
            return self.model(schema.get("title", name), schema, is_request=is_request)
        message = f"{name}: no Python type for {schema}"
        raise ValueError(message)


def alias(name: str, kind: str) -> str:
    """Returns the definition of a type that is not a class."""
    if name not in CONSTANTS:
        return f"{name} = {kind}"
    plain = kind.removeprefix("Annotated[").split(", Field(")[0]
    return (
        f"if TYPE_CHECKING:\n    {name} = {plain} | AnyArrayLike\n"
        f"else:\n    {name} = Annotated[{kind}, BeforeValidator(constant)]"
    )


def is_word(schema: Schema) -> bool:
    """Returns whether the schema is a string."""
    return schema.get("type") == "string"


def references(schema: object) -> Iterator[str]:
    """Yields the names of all referenced schemas."""
    if isinstance(schema, dict):
        if isinstance(schema.get("$ref"), str):
            yield schema["$ref"].rsplit("/", 1)[1]
        for value in schema.values():
            yield from references(value)
    elif isinstance(schema, list):
        for value in schema:
            yield from references(value)


def is_tagged(schema: Schema) -> bool:
    """Returns whether a field `kind` with one allowed value names the variant."""
    return len(schema.get("properties", {}).get("kind", {}).get("enum", [])) == 1


def is_nullable(schema: Schema) -> bool:
    """Returns whether the schema is a number or null: in requests, these are the bounds of the rows of a task."""
    return schema.get("type") == ["number", "null"]


def is_numeric(schema: Schema) -> bool:
    """Returns whether the schema is a number, a number or null, or an array of numbers of fixed size.

    Arrays without a size can differ in length, so an array of them is not a NumPy array.
    """
    is_array = "minItems" in schema and is_numeric(schema["items"])
    return is_array or schema.get("type") == "number" or is_nullable(schema)


def docstring(schema: Schema) -> str:
    """Returns the docstring of a schema."""
    text = describe(schema)
    return textwrap.fill(f'"""{text}"""', width=116) if text else ""


def describe(schema: Schema) -> str:
    """Returns the description of a schema and its fixed sizes."""
    text: str = schema.get("description", "")
    size, items = schema.get("minItems"), schema.get("items", {})
    if size and size == schema.get("maxItems"):
        inner = items.get("minItems")
        text += f" Shape: {size} × {inner}." if inner == items.get("maxItems") and inner else f" Shape: {size}."
    return text.strip()


def class_docstring(schema: Schema, fields: dict[str, Schema]) -> str:
    """Returns the docstring of a class: its description, and that of each field for `help()`."""
    described = [(name, describe(content)) for name, content in fields.items() if "description" in content]
    lines = [
        textwrap.fill(f"{name}: {text}", width=112, initial_indent="- ", subsequent_indent="  ")
        for name, text in described
    ]
    head = docstring(schema)
    return "\n".join([head.removesuffix('"""'), "", "Fields:", "", *lines, '"""']) if lines else head


def indented(text: str) -> list[str]:
    """Indents a text for a class body."""
    return [f"    {line}".rstrip() for line in text.splitlines()]


def remedies(document: Schema) -> str:
    """Returns the source of `REMEDIES`, from the table of problem types in the document's description."""
    rows = re.findall(r"^\| `(/problems/[\w-]+)` \| \d+ \| (?:.*?) \| (.*?) \|$", document["info"]["description"], re.M)
    entries = "".join(f"    {json.dumps(kind)}: {json.dumps(remedy)},\n" for kind, remedy in rows)
    return f'REMEDIES: dict[str, str] = {{\n{entries}}}\n"""What to do about each type of problem."""'


def source(document: Schema, module: str) -> str:
    """Returns the source text of a module: `models` or `problem`."""
    models = Models(document).written
    if module == "problem":
        return "\n\n".join([PROBLEM_HEADER, models["Problem"], remedies(document)]) + "\n"
    names = ", ".join(json.dumps(name) for name in sorted([*models, "REMEDIES"]))
    others = [text for name, text in models.items() if name != "Problem"]
    return "\n\n".join([HEADER, f"__all__ = [{names}]", *others]) + "\n"


if __name__ == "__main__":
    sys.stdout.write(source(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")), sys.argv[2]))
