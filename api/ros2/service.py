"""Calls of one revprio service over a connection that stays open, by the standard library alone."""

import json
from http.client import HTTPConnection, HTTPException

SILENCE = (OSError, HTTPException, ValueError)
"""What a call raises when there is no answer, or none that is a command: late, lost or refused."""


class Service:
    def __init__(self, address, timeout_s, token=None):
        self.connection = HTTPConnection(address, timeout=timeout_s)
        self.headers = {"Content-Type": "application/json"}
        if token:
            self.headers["Authorization"] = f"Bearer {token}"

    def call(self, method, path, body=None):
        """The answer as a dictionary; ValueError with the service's reason if it refuses."""
        text = None if body is None else json.dumps(body, allow_nan=False)
        try:
            self.connection.request(method, path, text, self.headers)
            response = self.connection.getresponse()
            answer = json.loads(response.read())
        except SILENCE:
            self.connection.close()  # A late answer must not pass for that of the next call.
            raise
        if response.status >= 400:
            raise ValueError(f"{answer['detail']} ({response.status}, {answer.get('pointer', path)})")
        return answer
