"""Every example in the document is valid by the schema beside it; so are the examples of single fields."""

import json
import sys

from jsonschema import Draft202012Validator

document = json.load(open(sys.argv[1]))
count = 0


def check(schema, value, place):
    global count
    count += 1
    whole = {"components": document["components"], **schema}
    errors = [f"{place}{error.json_path[1:]}: {error.message[:200]}" for error in Draft202012Validator(whole).iter_errors(value)]
    if errors:
        sys.exit("\n".join(errors))


def fields(schema, place):
    for name, field in schema.get("properties", {}).items():
        for value in field.get("examples", []):
            check(field, value, f"{place}/{name}")
        fields(field, f"{place}/{name}")
    for key in ("oneOf", "allOf"):
        for i, part in enumerate(schema.get(key, [])):
            fields(part, f"{place}/{i}")


for name, schema in document["components"]["schemas"].items():
    Draft202012Validator.check_schema(schema)
    fields(schema, name)
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
