#!/usr/bin/env python3
"""Makes the example laboratory: `lab_base.map` and `lab_graph.yaml`, beside this script.

The laboratory is 30 x 18 m: a corridor from west to east, three rooms on each side of it, and
doors 1.6 or 2 m wide. `walls()` and `furniture()` have everything that a laser would see;
`VERTICES` and `EDGES` are the graph. `omron_ros_map` makes `lab.map` from the two files.

Usage: make_lab.py [FOLDER]      (only the standard library is needed)
"""
from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Iterable, Iterator, List, Sequence, Set, Tuple

Point = Tuple[int, int]
Segment = Tuple[int, int, int, int]
Box = Tuple[int, int, int, int]  # x1, y1, x2, y2 with x1 < x2 and y1 < y2

PITCH = 20  # mm between scan points
ROOM: Box = (-15000, -9000, 15000, 9000)  # inner faces of the outer walls
WALL = 120  # mm, thickness of the inner walls
CORRIDOR = 1260  # mm, from the middle of the corridor (y = 0) to the middle of its walls

# -- the graph ------------------------------------------------------------------------------------

VERTICES = {  # id: (x m, y m, heading deg)
    # corridor, west to east
    8: (-12.0, 0.0, 0), 10: (-8.0, 0.0, 0), 12: (-4.5, 0.0, 0), 14: (0.0, 0.0, 0),
    32: (3.0, 0.0, 0), 33: (7.0, 0.0, 0), 35: (12.0, 0.0, 0),
    # robot hall, south-west; 16 is the dock, its station stands 1.5 m ahead of it
    1: (-12.0, -4.4, -90), 2: (-8.25, -7.0, 0), 4: (-4.5, -4.4, 90), 6: (-2.6, -7.0, 0),
    16: (-13.2, -7.0, 180),
    # electronics, north-west
    18: (-9.2, 7.2, 0), 20: (-12.0, 4.2, 90), 22: (-8.0, 4.2, -90),
    # meeting room, north
    24: (-4.5, 4.2, 90), 26: (0.0, 4.2, 90), 27: (-2.4, 7.2, 180),
    # workshop, north-east
    39: (13.0, 7.2, 0), 40: (7.0, 4.2, 90), 41: (12.0, 4.2, -90), 42: (9.5, 7.2, 0),
    # assembly, south, and store, south-east
    47: (3.0, -4.4, 0), 49: (12.0, -4.4, 90), 52: (9.4, -7.0, -135),
}

LINE, SPLINE = 'line', 'spline'
EDGES = [  # origin, destination, curve, ParamF and ParamB in m, velocity in m/s; ids count from 1
    # corridor
    (8, 10, LINE, 0.25, 1.0), (10, 12, LINE, 0.25, 1.0), (12, 14, LINE, 0.25, 1.0),
    (14, 32, LINE, 0.25, 1.0), (32, 33, LINE, 0.25, 1.0), (33, 35, LINE, 0.25, 1.0),
    # robot hall
    (8, 1, LINE, 0.25, 0.6), (1, 4, LINE, 0.25, 0.8), (4, 12, LINE, 0.25, 0.6),
    (1, 2, SPLINE, 1.6, 0.5), (2, 4, SPLINE, 1.6, 0.5), (2, 6, LINE, 0.25, 0.5),
    (1, 16, SPLINE, 1.2, 0.3),
    # electronics
    (8, 20, LINE, 0.25, 0.6), (20, 22, LINE, 0.25, 0.6), (22, 10, LINE, 0.25, 0.6),
    (20, 18, SPLINE, 1.6, 0.4),
    # meeting room, and the doors to its neighbours
    (22, 24, LINE, 0.25, 0.6), (12, 24, LINE, 0.25, 0.6), (24, 26, LINE, 0.25, 0.6),
    (26, 14, LINE, 0.25, 0.6), (26, 27, SPLINE, 1.6, 0.4), (26, 40, LINE, 0.25, 0.8),
    # workshop
    (33, 40, LINE, 0.25, 0.6), (40, 41, LINE, 0.25, 0.6), (41, 35, LINE, 0.25, 0.6),
    (40, 42, SPLINE, 1.5, 0.5), (42, 41, SPLINE, 1.5, 0.5), (42, 39, LINE, 0.25, 0.5),
    # assembly and store
    (4, 47, LINE, 0.25, 0.8), (32, 47, LINE, 0.25, 0.6), (47, 49, LINE, 0.25, 0.8),
    (49, 35, LINE, 0.25, 0.6), (49, 52, LINE, 0.25, 0.4),
]

# -- what a laser sees ----------------------------------------------------------------------------


def walls() -> List[Box]:
    """Returns the walls as boxes. Where two walls meet, the end of one lies inside the other."""
    x1, y1, x2, y2 = ROOM
    return [
        # outer walls
        (x1 - 200, y1 - 200, x2 + 200, y1), (x1 - 200, y2, x2 + 200, y2 + 200),
        (x1 - 200, y1 - 200, x1, y2 + 200), (x2, y1 - 200, x2 + 200, y2 + 200),
        # both sides of the corridor
        *pierced(x1 - 100, x2 + 100, CORRIDOR, [
            (-12000, 1600), (-8000, 1600), (-4500, 1600), (0, 1600), (7000, 1600),
            (12000, 1600)]),
        *pierced(x1 - 100, x2 + 100, -CORRIDOR, [
            (-12000, 2000), (-4500, 2000), (3000, 1600), (12000, 1600)]),
        # between the rooms
        *upright(pierced(CORRIDOR, y2 + 100, -6000, [(4200, 1600)])),
        *upright(pierced(CORRIDOR, y2 + 100, 3000, [(4200, 1600)])),
        *upright(pierced(y1 - 100, -CORRIDOR, -1000, [(-4400, 2000)])),
        *upright(pierced(y1 - 100, -CORRIDOR, 7000, [(-4400, 2000)])),
    ]


def pierced(start: int, end: int, middle: int, doors: Sequence[Tuple[int, int]]) -> List[Box]:
    """Returns the boxes of a wall along x. The doors (middle, width) are gaps between them."""
    boxes = []
    for door, width in sorted(doors):
        boxes.append((start, middle - WALL // 2, door - width // 2, middle + WALL // 2))
        start = door + width // 2
    boxes.append((start, middle - WALL // 2, end, middle + WALL // 2))
    return boxes


def upright(boxes: Iterable[Box]) -> List[Box]:
    """Returns the boxes with x and y swapped: walls along x become walls along y."""
    return [(y1, x1, y2, x2) for x1, y1, x2, y2 in boxes]


def furniture() -> Iterator[Segment]:
    """Yields the outlines of all objects that stand in the rooms."""
    boxes = [
        # electronics: benches at the walls, two islands, a bench in front of vertex 18
        (-14600, 8240, -7000, 9000), (-15000, 2600, -14400, 7400), (-10900, 1960, -9100, 3100),
        (-10200, 5240, -7300, 5940), (-7460, 6800, -6060, 7600),
        # meeting room: sideboards
        (2340, 5600, 2940, 8400), (-3600, 8440, -800, 9000), (-5600, 1320, -5300, 3000),
        # workshop: benches, two machines, a bench in front of vertex 39
        (3060, 5600, 3760, 8400), (4600, 8300, 8000, 9000), (8600, 8300, 12400, 9000),
        (8600, 5200, 10400, 6060), (14340, 6500, 15000, 7900), (8760, 2000, 10240, 3120),
        # robot hall: cell, benches, the docking station
        (-9600, -5900, -6900, -5400), (-11400, -9000, -4200, -8260), (-1760, -7700, -1060, -6300),
        (-3200, -3100, -1060, -2400), (-15000, -7260, -14700, -6740),
        # assembly: line, benches
        (0, -7300, 4000, -6300), (-400, -9000, 4400, -8400), (-940, -2700, 1800, -1960),
        (4200, -2700, 6300, -1960),
        # store: racks
        (14260, -8400, 15000, -1960), (7600, -2700, 10800, -1960), (11000, -9000, 13400, -8200),
        (12600, -6900, 13300, -5900),
        # pillars
        *(square(x, -3000, 400) for x in (-10400, -6200)),
        *(square(x, y, 400) for x in (5000,) for y in (2600, 6400)),
    ]
    for x1, y1, x2, y2 in boxes:
        yield from polygon([(x1, y1), (x2, y1), (x2, y2), (x1, y2)])
    yield from turned(13900, 2900, 1200, 800, 20)  # workshop: a lathe
    yield from turned(8300, -8100, 1400, 600, -45)  # store: the pick station ahead of vertex 52
    yield from round_table(-2260, 2700, 600)
    yield from round_table(-4500, 6900, 700)


def square(x: int, y: int, size: int) -> Box:
    """Returns a square box around this centre."""
    return (x - size // 2, y - size // 2, x + size // 2, y + size // 2)


def polygon(corners: Sequence[Point]) -> Iterator[Segment]:
    """Yields the sides of the polygon with these corners."""
    for (x1, y1), (x2, y2) in zip(corners, [*corners[1:], corners[0]]):
        yield (x1, y1, x2, y2)


def turned(x: int, y: int, width: int, height: int, degrees: float) -> Iterator[Segment]:
    """Returns the outline of a box with this centre and size, turned about its centre."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    half = [(-width / 2, -height / 2), (width / 2, -height / 2),
            (width / 2, height / 2), (-width / 2, height / 2)]
    return polygon([(round(x + u * c - v * s), round(y + u * s + v * c)) for u, v in half])


def round_table(x: int, y: int, radius: int, corners: int = 24) -> Iterator[Segment]:
    """Returns the outline of a round table, as a polygon."""
    angles = [2 * math.pi * (i + 0.5) / corners for i in range(corners)]
    return polygon([(round(x + radius * math.cos(a)), round(y + radius * math.sin(a)))
                    for a in angles])


def outlines(boxes: Sequence[Box]) -> Iterator[Segment]:
    """Yields the visible faces of walls: the parts of their sides in ROOM and in no other box."""
    x_min, y_min, x_max, y_max = ROOM
    for box in boxes:
        x1, y1, x2, y2 = box
        for y in (y1, y2):
            hidden = [(b[0], b[2]) for b in boxes if b[1] < y < b[3]]
            for start, end in remaining(max(x1, x_min), min(x2, x_max), hidden):
                if y_min <= y <= y_max:
                    yield (start, y, end, y)
        for x in (x1, x2):
            hidden = [(b[1], b[3]) for b in boxes if b[0] < x < b[2]]
            for start, end in remaining(max(y1, y_min), min(y2, y_max), hidden):
                if x_min <= x <= x_max:
                    yield (x, start, x, end)


def remaining(start: int, end: int, hidden: Iterable[Tuple[int, int]]) -> Iterator[Tuple[int, int]]:
    """Yields the parts of the interval start..end that no hidden interval covers."""
    for left, right in sorted(hidden):
        if left > start:
            yield from [(start, min(left, end))] if start < min(left, end) else []
        start = max(start, right)
    if start < end:
        yield (start, end)


def scan_points(segments: Iterable[Segment]) -> List[Point]:
    """Returns the points that a laser sees on these segments, sorted by x, then y.

    The points lie on a grid of PITCH. No point occurs twice.
    """
    points: Set[Point] = set()
    for x1, y1, x2, y2 in segments:
        steps = max(1, math.ceil(math.hypot(x2 - x1, y2 - y1) / (PITCH / 2)))
        for i in range(steps + 1):
            x, y = x1 + (x2 - x1) * i / steps, y1 + (y2 - y1) * i / steps
            points.add((PITCH * math.floor(x / PITCH + 0.5), PITCH * math.floor(y / PITCH + 0.5)))
    return sorted(points)


# -- the .map file --------------------------------------------------------------------------------

MAP_INFO = """\
MapInfo: GoalType Name=Goal "Label=Goal" "Desc=Place to drive to." Shape=Cross
MapInfo: DockType "Name=Dock" "Label=Dock" "Heading=Required" "NameRequired=1"
MapInfo: DockType "Name=DockLynx" "Label=LD dock" "Heading=Required" "NameRequired=1"
MapInfo: SectorType Name=ResistedSector "Label=Resisted sector" "Desc=Avoided where possible."
"""


def forbidden_area(x: float, y: float, width: float, height: float, degrees: float,
                   name: str) -> Tuple:
    """Returns the line of a ForbiddenArea, after the stored x and y by which objects are sorted.

    x, y, width and height are in mm; x and y are the centre. The file stores the corners in a frame
    turned about the map's origin.
    """
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    u, v = x * c + y * s, -x * s + y * c
    extent = [round(u - width / 2), round(v - height / 2), round(u + width / 2),
              round(v + height / 2)]
    line = 'Cairn: ForbiddenArea 0 0 {:.6f} "" ICON "{}" {} {} {} {}'.format(
        degrees, name, *extent)
    return (extent[0], extent[1], line)


def objects() -> List[str]:
    """Returns the lines of the objects, sorted by stored x and y, as by the vendor's tools."""
    return [line for _, _, line in sorted([
        forbidden_area(-8300, -2560, 2000, 800, 20, 'Test field'),
        forbidden_area(14200, 0, 1600, 2400, 0, 'Stairs'),
        forbidden_area(5700, -7800, 2300, 2300, 0, 'Wet bench'),
        (-14000, 1700, 'Cairn: ForbiddenLine -14000 1700 0.000000 "" ICON "Glass" '
                       '-14000 1700 -14000 8100'),
        (-12000, 0, 'Cairn: RobotHome -12000 0 0.000000 "" ICON ""'),
    ])]


def map_text() -> str:
    """Returns the text of the `.map` file."""
    lines = sorted(set(outlines(walls())) | set(furniture()))
    points = scan_points(lines)
    ends = [end for x1, y1, x2, y2 in lines for end in ((x1, y1), (x2, y2))]
    return '\n'.join([
        '2D-Map',
        'MinPos: {} {}'.format(*low(points)), 'MaxPos: {} {}'.format(*high(points)),
        f'NumPoints: {len(points)}', 'PointsAreSorted: true', f'Resolution: {PITCH}',
        'LineMinPos: {} {}'.format(*low(ends)), 'LineMaxPos: {} {}'.format(*high(ends)),
        f'NumLines: {len(lines)}', 'LinesAreSorted: true',
        *MAP_INFO.splitlines(), *objects(),
        'LINES', *('{} {} {} {}'.format(*line) for line in lines),
        'DATA', *('{} {}'.format(*point) for point in points), ''])


def low(points: Iterable[Point]) -> Point:
    """Returns the lower left corner of the box around the points."""
    xs, ys = zip(*points)
    return min(xs), min(ys)


def high(points: Iterable[Point]) -> Point:
    """Returns the upper right corner of the box around the points."""
    xs, ys = zip(*points)
    return max(xs), max(ys)


# -- the graph file -------------------------------------------------------------------------------


def graph_text() -> str:
    """Returns the trajectory graph as YAML, in the layout of the fleet manager's editor."""
    rows = ['# Trajectory graph of the example laboratory, made by make_lab.py.', 'Edges:']
    for number, (origin, destination, curve, reach, velocity) in enumerate(EDGES, 1):
        rows.append(
            f'- {{CurveType: {curve}, Destination_ID: {destination}, Id: {number}, '
            f'Origin_ID: {origin}, ParamB: {reach}, ParamF: {reach}, '
            f'VelocityBackwards: {min(velocity, 0.3)}, VelocityForward: {velocity}}}')
    rows.append('Vertices:')
    for vertex, (x, y, heading) in sorted(VERTICES.items()):
        theta = round(math.radians(heading), 8)
        rows.append(
            f'- {{FrameId: map/lab, Id: {vertex}, Label: {label(vertex)}, Theta: {theta}, '
            f'ThetaHolomonic: {theta}, X: {x}, Y: {y}}}')
    return '\n'.join([*rows, ''])


def label(vertex: int) -> str:
    """Returns the use of a vertex: the dock, a station (with one edge), or a place to pass."""
    if vertex == 16:
        return 'dock'
    edges = sum(vertex in (origin, destination) for origin, destination, *_ in EDGES)
    return 'station' if edges == 1 else 'pass'


def main(arguments: Sequence[str]) -> int:
    """Writes both files into the given folder, or beside this script."""
    folder = Path(arguments[0]) if arguments else Path(__file__).resolve().parent
    (folder / 'lab_base.map').write_bytes(map_text().encode())
    (folder / 'lab_graph.yaml').write_bytes(graph_text().encode())
    return 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
