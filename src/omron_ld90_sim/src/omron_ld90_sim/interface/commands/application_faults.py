"""Application faults: an application reports an error to the robot."""
from __future__ import annotations

from omron_ld90_sim.behaviour import instant_tasks
from omron_ld90_sim.devices.equipment import ApplicationFault
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command


@command('applicationFaultSet', 'Sets an application fault',
         '<name> "<short_description>" "<long_description>" <bool_driving> <bool_critical>', 5,
         'afs')
def application_fault_set(call: CommandCall) -> None:
    """Raises a fault."""
    name, short, long, driving, critical = call.arguments[:5]
    if not {driving, critical} <= {'0', '1'}:
        raise CommandFailed('driving and critical must be 0 or 1')
    call.reply(f'ApplicationFaultSet set {name}')
    instant_tasks.set_fault(call.robot, ApplicationFault(name, short, long, driving == '1',
                                                         critical == '1'))


@command('applicationFaultClear', 'Clears an application fault', '<name>', 1, 'afc')
def application_fault_clear(call: CommandCall) -> None:
    """Clears a fault."""
    name = call.arguments[0]
    if not instant_tasks.clear_fault(call.robot, name):
        raise CommandFailed(f"No application fault '{name}'")
    call.reply(f'ApplicationFaultClear cleared {name}')


@command('applicationFaultQuery', 'Gets the list of any application faults currently triggered',
         shortcut='afq')
def application_fault_query(call: CommandCall) -> None:
    """Lists the application faults."""
    for fault in call.robot.equipment.faults.values():
        call.reply(f'ApplicationFaultQuery: {fault}')
    call.reply('End of ApplicationFaultQuery')


@command('faultsGet', 'Gets the list of any faults currently triggered', shortcut='fg')
def faults_get(call: CommandCall) -> None:
    """Lists all faults; the simulated robot has only application faults."""
    for fault in call.robot.equipment.faults.values():
        call.reply(f'FaultList: {fault}')
    call.reply('End of FaultList')
