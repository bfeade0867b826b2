"""The ARCL commands, one module per group; importing this package fills `TABLE`."""
from omron_ld90_sim.commands import driving, session, state
from omron_ld90_sim.commands.table import TABLE, Call, CommandFailed, SetUpError, help_lines

__all__ = ['TABLE', 'Call', 'CommandFailed', 'SetUpError', 'driving', 'help_lines', 'session',
           'state']
