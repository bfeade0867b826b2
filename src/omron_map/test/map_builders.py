"""Small maps, written for the tests; each number can be checked by hand."""
from __future__ import annotations

from typing import Iterable, Sequence, Tuple

from omron_map import MapDocument

#: The smallest map with all parts; other fixtures are made from it.
CELL = b"""2D-Map
MinPos: -20 0
MaxPos: 60 40
NumPoints: 4
PointsAreSorted: true
Resolution: 20
LineMinPos: -23 0
LineMaxPos: 60 41
NumLines: 2
LinesAreSorted: true
Cairn: Goal 20 20 0.000000 "" ICON "North"
LINES
-23 0 60 0
60 0 60 41
DATA
-20 0
0 0
40 20
60 40
"""

GROUPS = """CairnInfo: GroupMember "Inner dock" "DockLynx" "Station" "DockGoal"
CairnInfo: Params "Crawl" "Slow" 250 0
CairnInfo: Params "Rest 1" "Shelf A" false
CustomInfo: ConfigSection "Name=Radio"
CustomInfo: ConfigParam "Name=Password" "Say "open"  or	"closed"; # is text" "Value=hush-hush"
MapInfo: DockType "Name=DockLynx" "Label=LD dock" "Heading=Required"
MapInfo: GoalType Name=Goal
MapInfo: GoalType Name=StandbyGoal "Label=Stand by"
MapInfo: SectorType Name=MovementParametersSector
MetaInfo: Scan "File=room.z2d" "Host=robot.example"
RouteInfo: GoalAfter "Shelf A"
RouteInfo: Task "move" 500
TaskInfo: TaskDesc "Name=greet" "Class=Talk" "Shelf A"
"""
OBJECTS = """Cairn: ForbiddenArea 0 0 180.000000 "" ICON "" -4900 -900 -4500 -500
Cairn: MovementParametersSector 0 0 -90.000000 "" ICON "Crawl" -900 300 -100 1100
Cairn: DockLynx -800 -700 90.000000 "" ICON "Dock"
Cairn: FeedbackHandler 0 0 0.000000 "" ICON "Replies" 0 0 0 0
Cairn: Goal 0 0 0.000000 "with, a comma" ICON "Shelf A"
Cairn: ForbiddenLine 500 -900 0.000000 "" ICON "Line" 500 -900 500 400
Cairn: RobotHome 900 100 0.000000 "" ICON "" 900 100 1300 500
Cairn: StandbyGoalWithHeading 1100 600 45.000000 "" ID=3 "Rest 1"
Cairn: ForbiddenArea 0 0 30.000000 "" ICON "Keep out" 2000 1000 5000 2000
Cairn: GoalWithHeading 2500 900 -90.000000 "" ICON "Türe 門"
_MapInfo: SectorType Name=OneWaySector
_Cairn: OneWaySector 0 0 0.000000 "" ICON "Switched off" 10 10 20 20
ChildCairn: DockLynx 1200 0 179.500000 "dock goal" ICON "Inner dock"
"""

TWO_SCANS = b"""2D-Map-Ex
Sources: High Low
HighDisplay: "Upper laser"
HighMinPos: 0 0
HighMaxPos: 200 100
HighNumPoints: 3
HighPointsAreSorted: true
HighResolution: 100
HighLineMinPos: 0 0
HighLineMaxPos: 200 0
HighNumLines: 1
HighLinesAreSorted: true
LowMinPos: 50 50
LowMaxPos: 50 150
LowNumPoints: 2
LowPointsAreSorted: true
LowResolution: 50
Cairn: Goal 20 20 0.000000 "" ICON "Middle"
High_LINES
0 0 200 0
High_DATA
0 0
100 100
200 0
Low_DATA
50 50
50 150
"""


def map_bytes(points: Iterable[Tuple[int, int]] = (), lines: Sequence[Sequence[int]] = (),
              objects: str = '', groups: str = '', resolution: int = 50,
              category: str = '2D-Map') -> bytes:
    """Returns a map as the vendor's tools write it, with a header that agrees with its rows."""
    points = sorted(set(points))
    lines = sorted(tuple(line) for line in lines)
    text = [category]
    if points:
        text += _header('', 'Points', points, points) + [f'Resolution: {resolution}']
    if lines:
        ends = [line[:2] for line in lines] + [line[2:] for line in lines]
        text += _header('Line', 'Lines', lines, ends)
    text += (groups + objects).split('\n')[:-1]
    if lines:
        text += ['LINES'] + [' '.join(map(str, line)) for line in lines]
    text += ['DATA'] + [f'{x} {y}' for x, y in points]
    return ('\n'.join(text) + '\n').encode()


def _header(prefix: str, what: str, rows: Sequence, ends: Sequence[Sequence[int]]) -> list:
    xs, ys = [x for x, _ in ends], [y for _, y in ends]
    return [f'{prefix}MinPos: {min(xs)} {min(ys)}', f'{prefix}MaxPos: {max(xs)} {max(ys)}',
            f'Num{what}: {len(rows)}', f'{what}AreSorted: true']


def room_bytes(objects: str = OBJECTS, groups: str = GROUPS) -> bytes:
    """Returns a room of 4 x 2 m, with its lower left corner at (-1, -1) m and a pitch of 50 mm.

    It has 238 wall points, 4 lines and 10 objects.
    """
    points = [(x, y) for x in range(-1000, 3001, 50) for y in (-1000, 1000)]
    points += [(x, y) for x in (-1000, 3000) for y in range(-950, 1000, 50)]
    lines = [(-1003, -1000, 3002, -1000), (-1000, -1000, -1000, 1000), (-1000, 1000, 3000, 1002),
             (3000, -1000, 3000, 1000)]
    return map_bytes(points, lines, objects, groups, category='2D-Map-Ex4')


def room() -> MapDocument:
    return MapDocument.from_bytes(room_bytes(), 'room.map')


def cell() -> MapDocument:
    return MapDocument.from_bytes(CELL, 'cell.map')


def changed_lines(before: bytes, after: bytes) -> Tuple[list, list]:
    """Returns the lines that only `before` has, and those that only `after` has."""
    old, new = before.splitlines(), after.splitlines()
    return [line for line in old if line not in new], [line for line in new if line not in old]
