"""Commands that read the loaded map's objects."""
from __future__ import annotations

from typing import Dict, List

from omron_ld90.maps import MapObject
from omron_ld90_sim.commands.table import Call, CommandFailed, command

# type -> meta type, label and description of the types an LD map declares
_TYPES: Dict[str, tuple] = {
    'Goal': ('GoalType', 'Goal', 'A goal'),
    'GoalWithHeading': ('GoalType', 'Goal with heading', 'A goal with a heading'),
    'DockLynx': ('DockType', 'Dock', 'A docking station'),
    'RobotHome': ('LocationType', 'Home', 'Where the robot may start'),
    'ForbiddenArea': ('SectorType', 'Forbidden area', 'An area the robot must not enter'),
    'ForbiddenLine': ('BoundaryType', 'Forbidden line', 'A line the robot must not cross'),
}


def _kinds(call: Call) -> List[str]:
    used = [obj.kind for obj in call.robot.document.objects]
    return sorted(set(_TYPES) | set(used), key=str.lower)


def _meta(kind: str) -> tuple:
    return _TYPES.get(kind, ('SectorType', kind, ''))


@command('mapObjectTypeList', 'Gets a list of map object types')
def map_object_type_list(call: Call) -> None:
    """Lists the types of objects."""
    for kind in _kinds(call):
        call.reply(f'MapObjectTypeList: {kind} {_meta(kind)[0]}')
    call.reply('End of MapObjectTypeList')


@command('mapObjectTypeInfo', 'Gets the information about a map object type', '<type>', 1)
def map_object_type_info(call: Call) -> None:
    """Tells about one type; its name is case-sensitive."""
    kind = call.text
    if kind not in _kinds(call):
        raise CommandFailed(f"No map object type '{kind}'")
    meta, label, description = _meta(kind)
    call.reply(f'MapObjectTypeList: {kind} {meta} "{label}" "{description}"')
    call.reply('End of MapObjectTypeInfo')


@command('mapObjectList', 'Gets a list of map objects of a given type', '<type>', 1)
def map_object_list(call: Call) -> None:
    """Lists the objects of one type; its name is case-sensitive."""
    kind = call.text
    if kind not in _kinds(call):
        raise CommandFailed(f"No map object type '{kind}'")
    for obj in call.robot.document.objects:
        if obj.kind == kind:
            call.reply(f'MapObjectList: "{obj.name}" {kind}')
    call.reply('End of MapObjectList')


@command('mapObjectInfo', 'Gets the information about a map object', '<name>', 1)
def map_object_info(call: Call) -> None:
    """Tells type, description and pose of one object."""
    obj = call.robot.document.find(call.text)
    if obj is None:
        raise CommandFailed(f"No map object '{call.text}'")
    call.reply(f'MapObjectInfo: "{obj.name}" {obj.kind} "{obj.description}"')
    if obj.extent is not None:
        e = obj.extent
        call.reply(f'MapObjectInfoParams: "{obj.name}" {e.from_x} {e.from_y} {e.to_x} {e.to_y}')
    call.reply(_coordinates(obj))
    call.reply('End of MapObjectInfo')


def _coordinates(obj: MapObject) -> str:
    return f'MapObjectInfoCoord: "{obj.name}" {obj.x:.0f} {obj.y:.0f} {obj.theta:.3f}'
