"""External inputs and outputs: commands that add and remove sets and update their values.

An update is sent to all clients, because one of them may be the device that drives the outputs.
All other answers go to the client that asked.
"""
from __future__ import annotations

from typing import Tuple

from omron_ld90_sim.devices.equipment import find_name
from omron_ld90_sim.devices.external_io import MAXIMUM_BITS, Bank, IoSet, parse_value
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command

RESTART = 5.0       # s for which the robot's software restarts after a set was removed


def _find(call: CommandCall) -> IoSet:
    sets = call.robot.equipment.io_sets
    return sets[call.named(sets, 'external I/O set')]


def _count(call: CommandCall, index: int) -> int:
    count = call.number(index)
    if not 0 <= count <= MAXIMUM_BITS or count != int(count):
        raise CommandFailed(f"Bad number '{call.arguments[index]}'")
    return int(count)


@command('extIOAdd', 'Adds an external IO set', '<name> <numInputs> <numOutputs>', 3, 'eda')
def add(call: CommandCall) -> None:
    """Creates a set with all bits off."""
    name, sets = call.arguments[0], call.robot.equipment.io_sets
    if find_name(sets, name) is not None:
        raise CommandFailed(f"There is an external I/O set '{name}' already")
    inputs, outputs = _count(call, 1), _count(call, 2)
    sets[name] = IoSet(name, Bank(inputs), Bank(outputs))
    call.reply(f'extIOAdd: {name} added with {inputs} input(s) and {outputs} output(s)')


@command('extIORemove', 'Removes an external IO set', '<name>', 1, 'edr')
def remove(call: CommandCall) -> None:
    """Removes a set; the robot's software then restarts, and every connection ends."""
    name = _find(call).name
    del call.robot.equipment.io_sets[name]
    call.reply(f'extIORemove: {name} removed')
    call.server.restart(RESTART)


def _dump(call: CommandCall, word: str) -> None:
    for io_set in call.robot.equipment.io_sets.values():
        call.reply(f'{word}: {io_set}')
    call.reply(f'End{word}')


@command('extIODump', 'Dumps the external IO sets', shortcut='edd')
def dump(call: CommandCall) -> None:
    """Lists every set with its values."""
    _dump(call, 'ExtIODump')


@command('extIODumpLocal', "Dumps this robot's external IO sets", shortcut='eddl')
def dump_local(call: CommandCall) -> None:
    """Lists every set with its values; a robot without a fleet has no other sets."""
    _dump(call, 'ExtIODumpLocal')


def _enter_updates(kind: str, key: str) -> None:
    """Adds the three update commands of the inputs or the outputs to the table."""
    lower = kind.lower()

    def found(call: CommandCall) -> Tuple[str, Bank]:
        io_set = _find(call)
        return io_set.name, io_set.inputs if kind == 'Input' else io_set.outputs

    def value_of(call: CommandCall, index: int) -> int:
        try:
            return parse_value(call.arguments[index])
        except ValueError as error:
            raise CommandFailed(f"Bad number '{call.arguments[index]}'") from error

    @command(f'extIO{kind}Update', f'Updates the {lower}s of an external IO set',
             '<name> <valueInHexOrDec>', 2, f'ed{key}u')
    def update(call: CommandCall) -> None:
        name, bank = found(call)
        bank.update(value_of(call, 1))
        call.server.broadcast(f'extIO{kind}Update: {lower} {name} updated with '
                              f'{bank.text} from {call.arguments[1]}')

    @command(f'extIO{kind}UpdateBit', f'Updates one {lower} of an external IO set',
             '<name> <bitPosition> <0 or 1>', 3, f'ed{key}b')
    def update_bit(call: CommandCall) -> None:
        (name, bank), position, bit = found(call), call.arguments[1], call.arguments[2]
        if bit not in ('0', '1'):
            raise CommandFailed(f"Bad bit '{bit}'")
        try:
            bank.set_bit(int(position), bit == '1')
        except ValueError as error:
            raise CommandFailed(f"Bad bit position '{position}'") from error
        call.server.broadcast(f'extIO{kind}UpdateBit: {lower} {name} updated with '
                              f'{bit} at bit {int(position)} to {bank.text}')

    @command(f'extIO{kind}UpdateByte', f'Updates eight {lower}s of an external IO set',
             '<name> <bytePosition> <valueInHex>', 3, f'ed{key}8')
    def update_byte(call: CommandCall) -> None:
        (name, bank), position, value = found(call), call.arguments[1], value_of(call, 2)
        if value > 0xff:
            raise CommandFailed(f"Bad number '{call.arguments[2]}'")
        try:
            bank.set_byte(int(position), value)
        except ValueError as error:
            raise CommandFailed(f"Bad byte position '{position}'") from error
        call.server.broadcast(f'extIO{kind}UpdateByte: {lower} {name} updated with '
                              f'0x{value:02x} at byte {int(position)} to {bank.text}')


_enter_updates('Input', 'i')
_enter_updates('Output', 'o')
