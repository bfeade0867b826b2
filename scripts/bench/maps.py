"""Measures maps: loading, grids, messages, start and memory of the node; each with its floor.

The benchmark uses the map of a real LD robot if there is one beside the repository, else the
example laboratory.
"""
from __future__ import annotations

import io
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path
from typing import Iterator, List, cast

import numpy as np
from genpy import Time
from geometry_msgs.msg import Point
from measuring.processes import resident
from measuring.ros_master import own_ros_master
from measuring.tables import Row, print_table
from measuring.timing import milliseconds
from nav_msgs.msg import MapMetaData
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from omron_ld90.nodes.map_visualisation import MARKER_ARRAYS, MARKERS
from omron_map import MapDocument, OccupancyGrid
from rviz_drawing.fast_messages import GridMessage, PointsMarker

ROOT = Path(__file__).resolve().parents[2]
REAL = Path(os.environ.get('LD90_REAL_MAPS') or '/nowhere') / 'omron-ld-site-a.map'
RUNS = 7
TOPICS = ['map', 'map_metadata', 'map_file', *MARKERS, *MARKER_ARRAYS]
BARE_NODE = '''
import rospy
from std_msgs.msg import String
rospy.init_node('bare')
publisher = rospy.Publisher('bare', String, queue_size=1, latch=True)
publisher.publish('up')
rospy.spin()
'''
MEMORY = '''
import gc, sys
from omron_map import MapDocument
def resident():
    gc.collect()
    lines = open('/proc/self/status').readlines()
    return int(next(line for line in lines if line.startswith('VmRSS')).split()[1]) * 1024
MapDocument.from_bytes(b'2D-Map\\nDATA\\n0 0\\n').warnings
before = resident()
document = MapDocument.load(sys.argv[1])
print(resident() - before)
'''


def load(path: Path) -> Row:
    """Loads a whole file; the floor is numpy's own reader for the points alone."""
    document = MapDocument.load(str(path))
    rows = document.sections[-1].body
    ours = milliseconds(lambda: MapDocument.load(str(path)))
    floor = milliseconds(lambda: np.loadtxt(io.BytesIO(rows), dtype=np.int32))
    return Row(f'load {path.name} ({len(document.points):,} points)',
               f'{ours:.1f} ms ({ours / floor:.2f} x)', f'np.loadtxt, points only: {floor:.1f} ms',
               'under 3 x')


def load_million() -> Row:
    """Loads a million points with checks; the floor is numpy's conversion of the same text without
    checks.
    """
    points = np.unique(np.random.default_rng(1).integers(-20_000, 20_000, (1_001_000, 2)) * 20,
                       axis=0)[:1_000_000]
    text = '\n'.join(f'{x} {y}' for x, y in cast(List[List[int]], points.tolist())) + '\n'
    low, high = points.min(axis=0), points.max(axis=0)
    head = (f'2D-Map\nMinPos: {low[0]} {low[1]}\nMaxPos: {high[0]} {high[1]}\n'
            f'NumPoints: {len(points)}\nPointsAreSorted: true\nResolution: 20\nDATA\n')
    data = (head + text).encode()
    ours = milliseconds(lambda: MapDocument.from_bytes(data))
    checked = milliseconds(lambda: MapDocument.from_bytes(data).warnings)
    rows = text.encode()
    floor = milliseconds(lambda: np.fromstring(rows, np.int64, sep=' '))
    return Row(f'load {len(points):,} points ({len(data) / 1e6:.1f} MB), validated',
               f'{ours:.0f} ms (with all warnings: {checked:.0f} ms)',
               f'np.fromstring, unchecked: {floor:.0f} ms', 'under 150 ms')


def grid() -> Row:
    """Builds and serialises a grid of 2400 x 2400 cells; the floor fills and copies the bytes."""
    side = 2400
    walls = [(i * 20, j) for i in range(side) for j in (0, 20 * (side - 1))]
    noise = np.random.default_rng(2).integers(0, side, (40_000, 2)) * 20
    points = np.unique(np.concatenate((walls, noise)), axis=0)
    text = ''.join(f'{x} {y}\n' for x, y in cast(List[List[int]], points.tolist()))
    document = MapDocument.from_bytes(f'2D-Map\nResolution: 20\nDATA\n{text}'.encode())

    def build() -> None:
        made = OccupancyGrid.from_map(document)
        assert made.cells.shape == (side, side)
        message = GridMessage(made.cells, header=Header(0, Time(1), 'map'), info=MapMetaData())
        message.serialize(io.BytesIO())

    def fill() -> None:
        io.BytesIO().write(np.full((side, side), -1, np.int8).data)
    return Row(f'grid of {side} x {side} cells from {len(points):,} points, serialised',
               f'{milliseconds(build):.1f} ms', f'filled and copied: {milliseconds(fill):.1f} ms',
               'under 15 ms')


def markers() -> Row:
    """Serialises a marker of 100,000 points; the floor is a list of Point objects."""
    array = np.random.default_rng(3).random((100_000, 3))
    fast = PointsMarker(array, type=Marker.POINTS)
    ours = milliseconds(lambda: fast.serialize(io.BytesIO()))
    plain = milliseconds(
        lambda: Marker(points=[Point(*row) for row in cast(List[List[float]], array.tolist())]
                       ).serialize(io.BytesIO()), runs=3)
    copy = milliseconds(lambda: io.BytesIO().write(array.data))
    return Row('marker of 100,000 points, serialised', f'{ours:.2f} ms',
               f'copied: {copy:.2f} ms; list of Point objects: {plain:.0f} ms', '')


def memory(path: Path) -> Row:
    """Measures how much memory a loaded document adds to a process that has already imported the
    library.
    """
    grown = [int(subprocess.run([sys.executable, '-c', MEMORY, str(path)], check=True,
                                stdout=subprocess.PIPE).stdout) for _ in range(RUNS)]
    size = path.stat().st_size
    growth = statistics.median(grown)
    return Row(f'memory of {path.name} loaded', f'{growth / 1e6:.1f} MB ({growth / size:.1f} x)',
               f'the file: {size / 1e6:.1f} MB', 'under 10 x')


def node(path: Path) -> List[Row]:
    """Measures the time from the node's start until all topics have a message, and the memory.

    The floor is a bare publisher.
    """
    import rospy
    with own_ros_master():
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        ours = [start_node([str(ROOT / 'src/omron_ld90/nodes/map_visualisation'),
                            f'_map_file:={path}'], TOPICS) for _ in range(RUNS)]
        with tempfile.NamedTemporaryFile(suffix='.map') as tiny:
            tiny.write(b'2D-Map\nResolution: 20\nDATA\n0 0\n')
            tiny.flush()
            empty = [start_node([str(ROOT / 'src/omron_ld90/nodes/map_visualisation'),
                                 f'_map_file:={tiny.name}'], TOPICS) for _ in range(3)]
        bare = [start_node(['-c', BARE_NODE], ['bare']) for _ in range(RUNS)]
    seconds, memory = (statistics.median(values) for values in zip(*ours))
    bare_seconds, _ = (statistics.median(values) for values in zip(*bare))
    _, empty_memory = (statistics.median(values) for values in zip(*empty))
    size = path.stat().st_size
    growth = memory - empty_memory
    return [
        Row(f'map_visualisation: start to {len(TOPICS)} latched topics', f'{seconds:.2f} s',
            f'bare rospy publisher: {bare_seconds:.2f} s', 'under 1.5 s'),
        Row('map_visualisation: memory for the map', f'{growth / 1e6:.1f} MB '
            f'({growth / size:.1f} x)', f'with a map of one point: {empty_memory / 1e6:.0f} MB',
            'under 10 x')]


def start_node(command: List[str], topics: List[str]) -> tuple:
    """Returns the time (s) from the start of a process until each topic has a message, and the
    memory of the process then.
    """
    import rospy
    missing, everything = set(topics), threading.Event()

    def heard(_message: object, topic: str) -> None:
        missing.discard(topic)
        if not missing:
            everything.set()
    subscribers = [rospy.Subscriber(topic, rospy.AnyMsg, heard, topic) for topic in topics]
    begin = time.perf_counter()
    process = subprocess.Popen([sys.executable, *command], stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        if not everything.wait(30.0):
            raise RuntimeError(f'nothing came on {", ".join(sorted(missing))}')
        seconds = time.perf_counter() - begin
        memory = resident(process.pid)
    finally:
        process.terminate()
        process.wait(10)
        for subscriber in subscribers:
            subscriber.unregister()
    return seconds, memory


def main() -> None:
    """Measures everything and prints the table."""
    warnings.simplefilter('ignore', DeprecationWarning)
    path = REAL if REAL.exists() else ROOT / 'maps' / 'lab.map'
    def rows() -> Iterator[Row]:
        yield from (load(path), load_million(), grid(), markers(), memory(path))
        yield from node(path)
    print_table(rows())


if __name__ == '__main__':
    main()
