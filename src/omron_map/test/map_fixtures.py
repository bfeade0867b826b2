"""Files that must be refused, and unusual files that must load and save unchanged."""
from __future__ import annotations

from typing import Dict, NamedTuple, Optional

from map_builders import CELL, TWO_SCANS


class Bad(NamedTuple):
    """A file to refuse. The error must name this line and field, and contain these words."""

    data: bytes
    line: Optional[int]
    field: Optional[str]
    words: str


GOAL = b'Cairn: Goal 20 20 0.000000 "" ICON "North"\n'


def _goal(line: bytes) -> bytes:
    """Returns the bytes of the map `CELL` with another object instead of its goal."""
    return CELL.replace(GOAL, line + b'\n')


def _cell(old: bytes, new: bytes) -> bytes:
    assert CELL.count(old) == 1, old
    return CELL.replace(old, new)


BAD: Dict[str, Bad] = {
    'empty file': Bad(b'', None, None, 'empty'),
    'only blank lines': Bad(b'\n\n', None, None, 'no category'),
    'another format': Bad(b'image: a.pgm\nresolution: 0.1\n', 1, 'category', 'not a map'),
    'category of a later version': Bad(_cell(b'2D-Map\n', b'2D-Map-Ex5\n'), 1, 'category',
                                       '2D-Map-Ex5 is not known'),
    'no section': Bad(CELL[:CELL.index(b'LINES\n')], 11, None, 'cut off'),
    'count is a word': Bad(_cell(b'NumPoints: 4', b'NumPoints: four'), 4, 'NumPoints', 'four'),
    'count is negative': Bad(_cell(b'NumLines: 2', b'NumLines: -2'), 9, 'NumLines', '-2'),
    'bound of one value': Bad(_cell(b'MaxPos: 60 40', b'MaxPos: 60'), 3, 'MaxPos', '60'),
    'pitch is a fraction': Bad(_cell(b'Resolution: 20', b'Resolution: 20.5'), 6, 'Resolution',
                               '20.5'),
    'pitch below -1': Bad(_cell(b'Resolution: 20', b'Resolution: -2'), 6, 'Resolution', '-2'),
    'sorted is no truth value': Bad(_cell(b'PointsAreSorted: true', b'PointsAreSorted: yes'), 5,
                                    'PointsAreSorted', 'yes'),
    'box too large': Bad(_cell(b'20\n60 40\n', b'20\n2000000 40\n'), 19, 'section', '2 km'),
    'coordinate of 33 bits': Bad(CELL + b'4294967296 0\n', 20, 'x', '4294967296'),
    'coordinate of 30 digits': Bad(CELL + b'9' * 30 + b' 0\n', 20, 'x', '999'),
    'object of five fields': Bad(_goal(b'Cairn: Goal 20 20 0.000000 ""'), 11, 'Cairn', '5 fields'),
    'x is a word': Bad(_goal(b'Cairn: Goal east 20 0 "" ICON "N"'), 11, 'x', 'east'),
    'y is hexadecimal': Bad(_goal(b'Cairn: Goal 20 0x14 0 "" ICON "N"'), 11, 'y', '0x14'),
    'theta is nan': Bad(_goal(b'Cairn: GoalWithHeading 2 2 nan "" ICON "N"'), 11, 'theta', 'nan'),
    'theta is infinite': Bad(_goal(b'Cairn: GoalWithHeading 2 2 -inf "" ICON "N"'), 11, 'theta',
                             'inf'),
    'theta beyond floats': Bad(_goal(b'Cairn: GoalWithHeading 2 2 1e999 "" ICON "N"'), 11, 'theta',
                               '1e999'),
    'area without corners': Bad(_goal(b'Cairn: ForbiddenArea 0 0 0 "" ICON "A"'), 11, 'from, to',
                                'four whole numbers'),
    'area of three numbers': Bad(_goal(b'Cairn: ForbiddenArea 0 0 0 "" ICON "A" 1 2 3'), 11,
                                 'from, to', '3 corner'),
    'area with a fraction': Bad(_goal(b'Cairn: ForbiddenArea 0 0 0 "" ICON "A" 1 2 3.5 4'), 11,
                                'to x', '3.5'),
    'quote left open': Bad(_goal(b'Cairn: Goal 20 20 0.000000 "" ICON "North'), 11, None,
                           'not closed'),
    'object between sections': Bad(_cell(b'DATA\n', GOAL + b'DATA\n'), 15, 'section', 'Cairn:'),
    'object after the rows': Bad(CELL + GOAL, 20, 'section', 'Cairn:'),
    'point is a word': Bad(_cell(b'40 20\n', b'40 y\n'), 18, 'y', "'y'"),
    'point is a fraction': Bad(_cell(b'40 20\n', b'40.5 20\n'), 18, 'x', '40.5'),
    'point with a lone minus': Bad(_cell(b'40 20\n', b'- 20\n'), 18, 'x', "'-'"),
    'point with a minus inside': Bad(_cell(b'40 20\n', b'4-0 20\n'), 18, 'x', '4-0'),
    'point with a plus': Bad(_cell(b'40 20\n', b'+40 20\n'), 18, 'x', '+40'),
    'point of one value': Bad(_cell(b'40 20\n', b'40\n'), 18, 'row', '2: x y'),
    'point of three values': Bad(_cell(b'40 20\n', b'40 20 7\n'), 18, 'row', '3 values'),
    'rows of one and three values': Bad(_cell(b'40 20\n60 40\n', b'40\n20 60 40\n'), 18, 'row',
                                        '1 values'),
    'line of three values': Bad(_cell(b'60 0 60 41\n', b'60 0 60\n'), 14, 'row', 'x1 y1 x2 y2'),
    'file cut inside a row': Bad(CELL[:-len(b' 40\n')], 19, 'row', 'ends inside a row'),
    'zero bytes': Bad(_cell(b'PointsAre', b'Points\0\0Are'), 5, None, 'zero byte'),
    'source named twice': Bad(TWO_SCANS.replace(b'High Low', b'High high'), 2, 'Sources', 'twice'),
    'section of no source': Bad(TWO_SCANS.replace(b'Low_DATA', b'Wide_DATA'), None, None,
                                'Wide_DATA'),
}


class Odd(NamedTuple):
    """A file to load and save; a warning must contain these words (None: no warning)."""

    data: bytes
    warning: Optional[str] = None


POLYGON = (b'Cairn: MotionLimitsSector 0 0 0.000000 "" ICON "Poly" 0 0 60 40 '
           b'5 0 0 60 0 60 40 30 60 0 40')

ODD: Dict[str, Odd] = {
    'as written': Odd(CELL),
    'two scans': Odd(TWO_SCANS),
    'CRLF': Odd(CELL.replace(b'\n', b'\r\n')),
    'byte order mark': Odd(b'\xef\xbb\xbf' + CELL, 'byte order mark'),
    'no final newline': Odd(CELL[:-1], 'no line end'),
    'blank lines': Odd(b'\n' + CELL.replace(b'Cairn', b'\nCairn').replace(b'DATA', b' \nDATA')
                       .replace(b'40 20\n', b'40 20\n\n') + b'\n'),
    'header after the objects': Odd(_cell(GOAL, b'').replace(b'2D-Map\n', b'2D-Map\n' + GOAL)),
    'whole theta, trailing blank': Odd(_goal(b'Cairn: RobotHome 10 10 54 "" ICON "" ')),
    'fraction of a millimetre': Odd(_goal(b'Cairn: Goal 10.25 -3.5 -91.9 "" ICON "N"')),
    'keys in lower case': Odd(CELL.replace(b'2D-Map', b'2d-map').replace(b'Num', b'num')
                              .replace(b'Cairn', b'cairn').replace(b'DATA', b'data')),
    'no lines': Odd(b'2D-Map\nResolution: 20\nDATA\n0 0\n'),
    'lines and no DATA': Odd(b'2D-Map\nResolution: 0\nLINES\n0 0 40 20\n'),
    'no header': Odd(b'2D-Map\n' + CELL[CELL.index(b'LINES\n'):]),
    'wrong count': Odd(_cell(b'NumPoints: 4', b'NumPoints: 7'), 'NumPoints says 7'),
    'wrong bounds': Odd(_cell(b'\nMinPos: -20 0', b'\nMinPos: -40 0'), 'MinPos says -40 0'),
    'unsorted': Odd(_cell(b'0 0\n40 20\n', b'40 20\n0 0\n'), 'not sorted'),
    'DATA before LINES': Odd(CELL[:CELL.index(b'LINES\n')] + CELL[CELL.index(b'DATA\n'):]
                             + CELL[CELL.index(b'LINES\n'):CELL.index(b'DATA\n')]),
    'a section that goes on': Odd(_cell(b'40 20\n', b'DATA\n40 20\n')),
    'a name twice': Odd(_goal(GOAL + b'Cairn: Goal 30 20 0.000000 "" ICON "NORTH"'),
                        'has the name of'),
    'a point and a line twice, a line of no length': Odd(
        _cell(b'40 20\n', b'40 20\n40 20\n').replace(b'NumPoints: 4', b'NumPoints: 5')
        .replace(b'60 0 60 41\n', b'60 0 60 0\n60 0 60 41\n60 0 60 41\n')
        .replace(b'NumLines: 2', b'NumLines: 4')),
    'tabs': Odd(_goal(b'Cairn:\tGoal  20\t20 0.0 "" ICON "a\tb"').replace(b'40 20\n', b'40\t20\n')),
    'swapped corners': Odd(_goal(b'Cairn: ForbiddenArea 0 0 90.000000 "" ICON "A" 40 20 0 0')),
    'theta of 270': Odd(_goal(b'Cairn: ForbiddenArea 0 0 270.000000 "" ICON "A" 0 0 40 20')),
    'a quote inside a name': Odd(_goal(b'Cairn: Goal 2 2 0.000000 "" ICON "6"x9 pipe"')),
    'a name in Latin-1': Odd(_goal(b'Cairn: Goal 20 20 0.000000 "" ICON "K\xfcche"')),
    'a polygon and unknown lines': Odd(_goal(b'# ?\nSpeed:   1.5   "x"\n' + POLYGON)),
    'a polygon cut short': Odd(_goal(POLYGON[:-len(b' 0 40')]), 'unknown meaning'),
    'a turned polygon': Odd(_goal(POLYGON.replace(b'0 0 0.000000', b'0 0 10.000000')),
                            'rectangle is drawn'),
    'an unknown kind with words behind': Odd(_goal(b'Cairn: Lamp.Red 1 2 0 "" ICON "L" 1 2 on'),
                                             'unknown meaning'),
    'first scan without its name': Odd(TWO_SCANS.replace(b'High Low', b'SickLaser Low')
                                       .replace(b'High_', b'').replace(b'\nHigh', b'\n')),
    'a dock kind that is not declared': Odd(
        _goal(b'MapInfo: DockType "Name=DockHD"\nCairn: DockLynx 0 0 0.000000 "" ICON "D"'),
        'Name=DockLynx'),
    'a route to a goal that is gone': Odd(_goal(b'RouteInfo: GoalAfter "South"'), "'South'"),
}
