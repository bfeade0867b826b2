"""Plants a defect in the programs of a fleet, to show that a soak would find it.

Python imports this module at its start if its folder is in PYTHONPATH. SOAK_PLANT names the defect.
The defect is planted into its module as soon as that module is imported.
"""
from __future__ import annotations

import importlib.abc
import importlib.machinery
import os
import sys
from types import ModuleType
from typing import Any, Callable, Dict, Optional, Sequence


def _without_places(module: Any) -> None:
    """The interlocking grants edges that are excluded by another robot's allocation."""
    module.CONDITIONS = tuple(one for one in module.CONDITIONS if one is not module._place_is_free)
    module.GATES = tuple(one for one in module.GATES if one is not module._robot_is_clear_of_others)


def _without_owed_stop(module: Any) -> None:
    """The controller forgets a stop that could not be sent."""
    module.MotionAuthority.stop_due = lambda self, now: False


def _without_stop_duty(module: Any) -> None:
    """The bridge treats a stop as obeyed as soon as it has sent it once."""
    module._NOT_TAKEN = ()


def _forgetful(module: Any) -> None:
    """After a restart, the supervisor does not know that the fleet is stopped."""
    value = module.Journal.value
    module.Journal.value = lambda self, name: 0 if name == module.STOPPED else value(self, name)


def _lossy(module: Any) -> None:
    """After a restart, the supervisor does not know the open missions."""
    module.Journal.missions = lambda self: []


_JOURNAL = 'graph_fleet_manager.supervision.journal'
PLANTS: Dict[str, Dict[str, Callable[[Any], None]]] = {
    'interlocking': {'graph_fleet_manager.interlocking.interlocking': _without_places},
    'owed-stop': {'omron_arcl.motion_authority': _without_owed_stop,
                  'omron_ld90.bridge.stop_duty': _without_stop_duty},
    'restart': {_JOURNAL: _forgetful},
    'restart-missions': {_JOURNAL: _lossy}}
"""For each defect, the modules to change and the function that changes each."""


class _Planter(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Loads the module as usual, then plants the defect."""

    def __init__(self, module: str, plant: Callable[[Any], None]) -> None:
        self._module, self._plant = module, plant
        self._loader: Any = None

    def find_spec(self, name: str, path: Optional[Sequence[str]],
                  target: Optional[ModuleType] = None) -> Optional[importlib.machinery.ModuleSpec]:
        """Finds only the one module."""
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
