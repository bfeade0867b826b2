"""The ARCL commands, one module per group; importing this package fills `TABLE`.

What the facts call unknown is not here: the server answers `Unknown command`.
"""
from omron_ld90_sim.commands import (
    application_faults,
    configuration,
    data_store,
    driving,
    external_io,
    inputs_outputs,
    map_objects,
    payload,
    session,
    state,
    tasks,
)
from omron_ld90_sim.commands.table import TABLE, Call, CommandFailed, SetUpError, help_lines

__all__ = ['TABLE', 'Call', 'CommandFailed', 'SetUpError', 'application_faults', 'configuration',
           'data_store', 'driving', 'external_io', 'help_lines', 'inputs_outputs', 'map_objects',
           'payload', 'session', 'state', 'tasks']
