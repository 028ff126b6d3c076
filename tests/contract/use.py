"""Imports all modules of the generated client and sends a request with it."""

import importlib
import json
import pkgutil
import sys

import revprio_client
from revprio_client import Client
from revprio_client.api.resolve import resolve
from revprio_client.models import ResolveRequest

for module in pkgutil.walk_packages(revprio_client.__path__, "revprio_client."):
    importlib.import_module(module.name)

request = ResolveRequest.from_dict(json.load(open("api/examples/resolve.json")))
answer = resolve.sync(client=Client(base_url=sys.argv[1]), body=request)
assert abs(answer.tasks[0].achieved[0] - 0.05) < 1e-9, answer
