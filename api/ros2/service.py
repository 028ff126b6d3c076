"""HTTP client of a revprio service with one persistent connection. It needs only the standard library."""

import json
from http.client import HTTPConnection, HTTPException
from uuid import uuid4

NO_COMMAND_ERRORS = (OSError, HTTPException, ValueError)
"""Exceptions of a call that returns no command: the answer is late, lost or a refusal."""


class Service:
    def __init__(self, address, timeout_s, token=None):
        self.connection = HTTPConnection(address, timeout=timeout_s)
        # The owner token: no other client can step the sessions of this one.
        self.headers = {"Content-Type": "application/json", "Revprio-Owner": str(uuid4())}
        if token:
            self.headers["Authorization"] = f"Bearer {token}"

    def call(self, method, path, body=None):
        """Returns the answer as a dictionary; raises ValueError with the reason if the service refuses."""
        text = None if body is None else json.dumps(body, allow_nan=False)
        try:
            self.connection.request(method, path, text, self.headers)
            response = self.connection.getresponse()
            answer = json.loads(response.read())
        except NO_COMMAND_ERRORS:
            self.connection.close()  # Otherwise a late answer would be read as the answer to the next call.
            raise
        if response.status >= 400:
            raise ValueError(f"{answer['detail']} ({response.status}, {answer.get('pointer', path)})")
        return answer
