"""Scenario scripts as modules, so that tests can ask their functions."""

import importlib.util

from rotor_ida.paper.reproduction import scenario_scripts


def scenario(name):
    """Return a scenario script as a module."""
    spec = importlib.util.spec_from_file_location(name, scenario_scripts()[name])
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
