"""The payload: the contents of the robot's slots, as clients declare them."""
from __future__ import annotations

from typing import List

from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command


def _slot(call: CommandCall) -> int:
    text = call.arguments[0]
    if not text.isdigit() or not 1 <= int(text) <= len(call.robot.equipment.slots):
        raise CommandFailed(f"No payload slot '{text}'")
    return int(text)


@command('payloadQueryLocal', "Queries this robot's payload", '[slotNumber or "default"] '
         '[echoString]', shortcut='pql')
def query_local(call: CommandCall) -> None:
    """Lists the content of every slot, or of one."""
    slots = call.robot.equipment.slots
    wanted: List[int] = list(slots)
    if call.arguments and call.arguments[0].lower() != 'default':
        wanted = [_slot(call)]
    echo = call.arguments[1] if len(call.arguments) > 1 else '""'
    for slot in wanted:
        load = slots[slot]
        content = f'"{load.text}" {load.since}' if load else '"Empty" None None'
        call.reply(f'PayloadQuery: {slot} {content} {echo}')
    call.reply('EndPayloadQuery')


@command('payloadSet', "Sets the payload of one of this robot's slots",
         '<slot_number> <slot_string>', 2, 'ps')
def set_slot(call: CommandCall) -> None:
    """Declares the content of a slot."""
    slot, text, robot = _slot(call), ' '.join(call.arguments[1:]), call.server.robot_name
    call.reply(f'payloadset attempting to set payload {slot} "{text}"')
    call.robot.equipment.load(slot, text, call.server.date_time)
    call.reply(f'payloadset on "{robot}" of slot number {slot} with string "{text}" '
               f'successfully set')
    call.server.broadcast(f'PayloadUpdate: "{robot}" {slot} "{text}"')


@command('payloadRemove', "Empties one of this robot's slots", '<slot_number>', 1, 'pr')
def remove(call: CommandCall) -> None:
    """Declares a slot empty."""
    slot, robot = _slot(call), call.server.robot_name
    call.reply(f'payloadremove attempting to remove slot {slot}')
    call.robot.equipment.unload(slot)
    call.reply(f'payloadremove on {robot} of slot number {slot} successfully')
    call.server.broadcast(f'PayloadUpdate: "{robot}" {slot} "Empty" None None')


@command('payloadSlotCountLocal', "Queries this robot's number of slots", shortcut='pscl')
def slot_count_local(call: CommandCall) -> None:
    """Answers the number of slots."""
    call.reply(f'PayloadSlotCount: "{call.server.robot_name}" {len(call.robot.equipment.slots)}')
    call.reply('EndPayloadSlotCount')
