"""Application faults: an application tells the robot that something is wrong."""
from __future__ import annotations

from omron_ld90_sim.commands.table import Call, CommandFailed, command
from omron_ld90_sim.equipment import ApplicationFault
from omron_ld90_sim.states import DockingState


@command('applicationFaultSet', 'Sets an application fault',
         '<name> "<short_description>" "<long_description>" <bool_driving> <bool_critical>', 5,
         'afs')
def application_fault_set(call: Call) -> None:
    """Raises a fault; a driving fault stops the robot and keeps it from driving."""
    name, short, long, driving, critical = call.arguments[:5]
    if not {driving, critical} <= {'0', '1'}:
        raise CommandFailed('driving and critical must be 0 or 1')
    fault = ApplicationFault(name, short, long, driving == '1', critical == '1')
    call.robot.equipment.faults[name] = fault
    call.reply(f'ApplicationFaultSet set {name}')
    call.server.broadcast(f'Fault: {fault}')
    if fault.driving:
        call.robot.block('fault', name)


@command('applicationFaultClear', 'Clears an application fault', '<name>', 1, 'afc')
def application_fault_clear(call: Call) -> None:
    """Takes a fault back; a robot that may drive again says a lone `Stopping` (I617-E-02 p. 57)."""
    name = call.arguments[0]
    fault = call.robot.equipment.faults.pop(name, None)
    if fault is None:
        raise CommandFailed(f"No application fault '{name}'")
    robot = call.robot
    freed = robot.unblock('fault', name) and robot.can_drive
    call.server.broadcast(f'FaultCleared: {fault}')
    if freed and robot.docking.state is DockingState.UNDOCKED:
        call.server.broadcast('Stopping')
    call.reply(f'ApplicationFaultClear cleared {name}')


@command('applicationFaultQuery', 'Gets the list of any application faults currently triggered',
         shortcut='afq')
def application_fault_query(call: Call) -> None:
    """Lists the application faults."""
    for fault in call.robot.equipment.faults.values():
        call.reply(f'ApplicationFaultQuery: {fault}')
    call.reply('End of ApplicationFaultQuery')


@command('faultsGet', 'Gets the list of any faults currently triggered', shortcut='fg')
def faults_get(call: Call) -> None:
    """Lists all faults; the simulated robot knows those of applications."""
    for fault in call.robot.equipment.faults.values():
        call.reply(f'FaultList: {fault}')
    call.reply('End of FaultList')
