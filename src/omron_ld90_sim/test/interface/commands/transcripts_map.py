"""Transcripts: goals, routes, macros and map objects (form as in `transcripts_state`)."""
from __future__ import annotations

IMMEDIATE = {
    'getGoals': [['getGoals'], ['Goal: West', 'Goal: East side', 'Goal: 12', 'End of goals']],
    'getRoutes': [['getRoutes'], ['Routes', 'Route: Round', 'End of routes']],
    'getMacros': [['getMacros'], ['Macro: Greeting', 'End of macros']],
    'mapObjectTypeList': [['mapObjectTypeList'], [
        'MapObjectTypeList: DockLynx DockType', 'MapObjectTypeList: ForbiddenArea SectorType',
        'MapObjectTypeList: ForbiddenLine BoundaryType', 'MapObjectTypeList: Goal GoalType',
        'MapObjectTypeList: GoalWithHeading GoalType', 'MapObjectTypeList: RobotHome LocationType',
        'End of MapObjectTypeList']],
    'mapObjectTypeInfo': [['mapObjectTypeInfo Goal', 'mapObjectTypeInfo goal'], [
        'MapObjectTypeList: Goal GoalType "" ""', 'End of MapObjectTypeInfo',
        'CommandError: mapObjectTypeInfo goal',
        "CommandErrorDescription: No map object type 'goal'"]],
    'mapObjectList': [['mapObjectList Goal', 'mapObjectList "Goal"'], [
        'MapObjectList: "West" Goal', 'MapObjectList: "12" Goal', 'End of MapObjectList',
        'CommandError: mapObjectList "Goal"',
        "CommandErrorDescription: No map object type '\"Goal\"'"]],
    'mapObjectInfo': [['mapObjectInfo east side', 'mapObjectInfo moon'], [
        'MapObjectInfo: "East side" GoalWithHeading "the far end"',
        'MapObjectInfoCoord: "East side" 4500 1500 90.000', 'End of MapObjectInfo',
        'CommandError: mapObjectInfo moon', "CommandErrorDescription: No map object 'moon'"]],
    'distanceFromHere': [['distanceFromHere West'], ['DistanceFromHere: 1500 "West"']],
    'distanceBetween': [['distanceBetween West 12'], [r'/DistanceBetween: 9\d{3} "West" "12"/']],
}
