"""Checks that every example in the OpenAPI document is valid by its schema, including examples of single fields."""

import json
import sys

from jsonschema import Draft202012Validator

document = json.load(open(sys.argv[1]))
count = 0


def check(schema, value, location):
    global count
    count += 1
    with_references = {"components": document["components"], **schema}
    errors = Draft202012Validator(with_references).iter_errors(value)
    messages = [f"{location}{error.json_path[1:]}: {error.message[:200]}" for error in errors]
    if messages:
        sys.exit("\n".join(messages))


def check_fields(schema, location):
    for name, field in schema.get("properties", {}).items():
        for value in field.get("examples", []):
            check(field, value, f"{location}/{name}")
        check_fields(field, f"{location}/{name}")
    for key in ("oneOf", "allOf"):
        for i, part in enumerate(schema.get(key, [])):
            check_fields(part, f"{location}/{i}")


for name, schema in document["components"]["schemas"].items():
    Draft202012Validator.check_schema(schema)
    check_fields(schema, name)
for path, item in document["paths"].items():
    for method, operation in item.items():
        if method == "parameters":
            continue
        for part in [operation.get("requestBody", {}), *operation["responses"].values()]:
            for media in part.get("content", {}).values():
                for name, example in media.get("examples", {}).items():
                    check(media["schema"], example["value"], f"{method} {path} {name}")
assert count > 200, count
print(f"{count} examples are valid")
