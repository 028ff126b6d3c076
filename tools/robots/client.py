"""Modules of the Python client that need no other part of it."""
import importlib.util
import sys
from pathlib import Path

CLIENT = Path(__file__).parents[2] / 'api/python/src/revprio'


def module(name):
    spec = importlib.util.spec_from_file_location(f'revprio_{name}', CLIENT / f'{name}.py')
    found = sys.modules[spec.name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(found)
    return found
