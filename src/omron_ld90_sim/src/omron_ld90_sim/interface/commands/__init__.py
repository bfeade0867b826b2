"""The ARCL commands, one module per group; `execute` carries out one command line.

Importing this package fills `TABLE`.

Commands that no source describes (docs/explanation/sources.md) are not implemented: the server
answers `Unknown command`.
"""
from omron_ld90_sim.interface.commands import (
    application_faults,
    configuration,
    data_store,
    driving,
    external_io,
    inputs_outputs,
    map_objects,
    payload,
    queuing,
    session,
    state,
    tasks,
)
from omron_ld90_sim.interface.commands.interpreter import execute
from omron_ld90_sim.interface.commands.table import TABLE

__all__ = ['TABLE', 'application_faults', 'configuration', 'data_store', 'driving', 'execute',
           'external_io', 'inputs_outputs', 'map_objects', 'payload', 'queuing',
           'session', 'state', 'tasks']
