"""Types and parameters of map objects: the examples of ARCL manual I617-E-02 p. 140-146."""
from __future__ import annotations

from sim_builders import ROOM, Rig

from omron_map import MapDocument

SECTORS = """
MapInfo: SectorType Name=DriveOnRightSector "Label=PreferredDirectionRightSingle" \
"Desc=One Way Drive on Right" Shape=Plain
MapInfo: ArgDesc Name=UseDefaultSideOffset Parent=DriveOnRightSector Type=bool Value=true \
Priority=Normal "Desc=Anything but "true", which is the default."
MapInfo: ArgDesc Name=PreferredDirectionSideOffset Parent=DriveOnRightSector Type=int Value=250 \
Min=1 Priority=Normal "Desc=The side offset for this sector."
MapInfo: ArgDesc Name=Name Parent=Other Type=string "Desc=Never closed
CairnInfo: Params "PreferredDirectionRightSingle1" true 300 "two words" ""
Cairn: DriveOnRightSector 0 0 0.000000 "" ICON "PreferredDirectionRightSingle1" 0 2000 900 2900
Cairn: DriveOnRightSector 0 0 0.000000 "" ICON "PreferredDirectionRightSingle2" 0 1000 900 1900
Cairn: StandbyGoalWithHeading -3500 2500 0.000000 "" ICON "Aside"
"""


def ask(command: str):
    document = MapDocument.from_bytes(ROOM.replace('\nCairn:', SECTORS + 'Cairn:', 1).encode())
    return Rig(document).client().ask(command)


def test_the_types_that_the_map_declares_are_listed() -> None:
    lines = ask('mapObjectTypeList')
    assert 'MapObjectTypeList: DriveOnRightSector SectorType' in lines
    assert lines[-1] == 'End of MapObjectTypeList'


def test_a_type_is_told_with_its_parameters() -> None:
    assert ask('mapObjectTypeInfo DriveOnRightSector') == [
        'MapObjectTypeList: DriveOnRightSector SectorType "PreferredDirectionRightSingle" '
        '"One Way Drive on Right"',
        'MapObjectTypeInfoArgument: UseDefaultSideOffset bool Normal '
        '"Anything but "true", which is the default."',
        'MapObjectTypeInfoArgument: PreferredDirectionSideOffset int Normal '
        '"The side offset for this sector."', 'End of MapObjectTypeInfo']


def test_the_objects_of_a_declared_type_are_listed() -> None:
    assert ask('mapObjectList DriveOnRightSector') == [
        'MapObjectList: "PreferredDirectionRightSingle1" DriveOnRightSector',
        'MapObjectList: "PreferredDirectionRightSingle2" DriveOnRightSector',
        'End of MapObjectList']


def test_an_object_is_told_with_its_parameters_quoted_where_they_hold_blanks() -> None:
    name = 'PreferredDirectionRightSingle1'
    assert ask(f'mapobjectinfo {name}') == [
        f'MapObjectInfo: "{name}" DriveOnRightSector ""',
        f'MapObjectInfoParams: "{name}" true 300 "two words" ""',
        f'MapObjectInfoCoord: "{name}" 0 0 0.000', 'End of MapObjectInfo']


def test_an_object_without_parameters_has_no_line_for_them() -> None:
    lines = ask('mapObjectInfo PreferredDirectionRightSingle2')
    assert not [line for line in lines if line.startswith('MapObjectInfoParams')], lines
    assert len(lines) == 3


def test_a_type_that_is_used_undeclared_is_listed_too() -> None:
    assert 'MapObjectTypeList: StandbyGoalWithHeading SectorType' in ask('mapObjectTypeList')
    assert ask('mapObjectList StandbyGoalWithHeading') == [
        'MapObjectList: "Aside" StandbyGoalWithHeading', 'End of MapObjectList']
