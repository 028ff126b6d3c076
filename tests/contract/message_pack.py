"""Hooks for schemathesis: it sends only JSON requests, and it can read answers in MessagePack."""

import msgpack
import schemathesis


@schemathesis.hook
def before_load_schema(_context, raw_schema):
    for item in raw_schema["paths"].values():
        for operation in item.values():
            if isinstance(operation, dict) and "requestBody" in operation:
                del operation["requestBody"]["content"]["application/msgpack"]


@schemathesis.deserializer("application/msgpack")
def read(_context, response):
    return msgpack.unpackb(response.content)
