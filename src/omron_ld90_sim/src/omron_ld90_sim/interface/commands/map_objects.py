"""Commands that read the loaded map's objects."""
from __future__ import annotations

from omron_ld90_sim.interface import map_types
from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command
from omron_map import MapObject


def _asked(call: CommandCall) -> map_types.ObjectType:
    """Returns the type that the command names; case matters, and quotes are not removed."""
    name = call.rest.split()[0]
    for known in map_types.object_types(call.robot.document):
        if known.name == name:
            return known
    raise CommandFailed(f"No map object type '{name}'")


@command('mapObjectTypeList', 'Gets a list of map object types')
def map_object_type_list(call: CommandCall) -> None:
    """Lists the types of objects."""
    for known in map_types.object_types(call.robot.document):
        call.reply(f'MapObjectTypeList: {known.name} {known.meta}')
    call.reply('End of MapObjectTypeList')


@command('mapObjectTypeInfo', 'Gets the information about a map object type', '<type>', 1)
def map_object_type_info(call: CommandCall) -> None:
    """Describes one type and the parameters of its objects."""
    known = _asked(call)
    call.reply(f'MapObjectTypeList: {known.name} {known.meta} "{known.label}" '
               f'"{known.description}"')
    for argument in map_types.arguments(call.robot.document, known.name):
        call.reply(f'MapObjectTypeInfoArgument: {argument.name} {argument.type} '
                   f'{argument.importance} "{argument.description}"')
    call.reply('End of MapObjectTypeInfo')


@command('mapObjectList', 'Gets a list of map objects of a given type', '<type>', 1)
def map_object_list(call: CommandCall) -> None:
    """Lists the objects of one type."""
    kind = _asked(call).name
    for obj in call.robot.document.objects:
        if obj.kind == kind:
            call.reply(f'MapObjectList: "{obj.name}" {kind}')
    call.reply('End of MapObjectList')


@command('mapObjectInfo', 'Gets the information about a map object', '<name>', 1)
def map_object_info(call: CommandCall) -> None:
    """Answers type, description, parameters and pose of one object."""
    obj = call.robot.document.find(call.text)
    if obj is None:
        raise CommandFailed(f"No map object '{call.text}'")
    call.reply(f'MapObjectInfo: "{obj.name}" {obj.kind} "{obj.description}"')
    values = map_types.parameters(call.robot.document, obj.name)
    if values:
        call.reply(f'MapObjectInfoParams: "{obj.name}" {" ".join(map(_bare_or_quoted, values))}')
    call.reply(_coordinates(obj))
    call.reply('End of MapObjectInfo')


def _coordinates(obj: MapObject) -> str:
    return f'MapObjectInfoCoord: "{obj.name}" {obj.x:.0f} {obj.y:.0f} {obj.theta:.3f}'


def _bare_or_quoted(value: str) -> str:
    return f'"{value}"' if ' ' in value or not value else value
