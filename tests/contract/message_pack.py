"""MessagePack for schemathesis."""

import msgpack
import schemathesis


@schemathesis.serializer("application/msgpack")
def written(_context, value):
    return msgpack.packb(value)


@schemathesis.deserializer("application/msgpack")
def read(_context, response):
    return msgpack.unpackb(response.content)
