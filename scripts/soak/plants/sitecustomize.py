"""Plants a defect in the programs of a fleet. This tests whether the soak finds the defect.

Python imports this file at its start if the file's folder is in PYTHONPATH. The environment
variable SOAK_PLANT names the defect. Each module that the defect concerns is changed when it is
imported.
"""
from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
import sys
from types import ModuleType
from typing import Any, Callable, Dict, Optional, Sequence


def _without_places(module: Any) -> None:
    """Makes the interlocking grant edges that another robot's allocation excludes."""
    module.CONDITIONS = tuple(one for one in module.CONDITIONS if one is not module._place_is_free)
    module.GATES = tuple(one for one in module.GATES if one is not module._robot_is_clear_of_others)


def _without_owed_stop(module: Any) -> None:
    """Makes the controller forget a stop that could not be sent."""
    module.Drives.stop_due = lambda self, now: False


def _without_second_try(module: Any) -> None:
    """Makes the bridge regard each stop as obeyed once it has sent the stop."""
    ended = module.LastWord.ended

    def taken(self: Any, event: Any, now: float) -> None:
        ended(self, event, now)
        if self.is_stop:
            self.is_taken, self.must_be_given = True, False
    module.LastWord.ended = taken


def _forgetful(module: Any) -> None:
    """Makes a restarted supervisor forget that the fleet is stopped."""
    value = module.Journal.value
    module.Journal.value = lambda self, name: 0 if name == module.STOPPED else value(self, name)


def _lossy(module: Any) -> None:
    """Makes a restarted supervisor forget all open missions."""
    module.Journal.missions = lambda self: []


_JOURNAL = 'fleet_core.supervision.journal'
PLANTS: Dict[str, Dict[str, Callable[[Any], None]]] = {
    'interlocking': {'fleet_core.interlocking.interlocking': _without_places},
    'owed-stop': {'omron_arcl.drives': _without_owed_stop,
                  'omron_ld90.bridge.last_word': _without_second_try},
    'restart': {_JOURNAL: _forgetful},
    'restart-missions': {_JOURNAL: _lossy}}
"""By defect: the modules to change, each with the function that changes the module."""


class _Planter(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads one module as usual, then plants the defect in it."""

    def __init__(self, module: str, plant: Callable[[Any], None]) -> None:
        self._module, self._plant = module, plant
        self._loader: Any = None

    def find_spec(self, name: str, path: Optional[Sequence[str]],
                  target: Optional[ModuleType] = None) -> Optional[importlib.machinery.ModuleSpec]:
        """Returns a spec with this loader for the module to change; None for all other modules."""
        if name != self._module:
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path, target)
        if spec is not None:
            self._loader, spec.loader = spec.loader, self
        return spec

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> Optional[ModuleType]:
        """Creates the module as usual."""
        module: Optional[ModuleType] = self._loader.create_module(spec)
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Executes the module as usual, then plants the defect."""
        self._loader.exec_module(module)
        self._plant(module)
        print(f'planted: {os.environ["SOAK_PLANT"]}', file=sys.stderr)


if os.environ.get('SOAK_PLANT'):
    for _name, _defect in PLANTS[os.environ['SOAK_PLANT']].items():
        sys.meta_path.insert(0, _Planter(_name, _defect))
