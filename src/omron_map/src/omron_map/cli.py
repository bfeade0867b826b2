"""`ld_map`: shows, checks and converts `.map` files, without ROS.

The command never prints the robot's configuration in a map, because it may have passwords and host
addresses.
"""
from __future__ import annotations

import argparse
import io
import os
import sys
from collections import Counter
from typing import Iterator, List, Optional

from omron_map.canvas import LONG_SIDE
from omron_map.compare import compare
from omron_map.document import MapDocument
from omron_map.errors import MapError
from omron_map.grid_files import export_grid
from omron_map.objects import MapObject
from omron_map.occupancy import FREE, UNKNOWN, USES, OccupancyGrid
from omron_map.picture import draw_map
from omron_map.reach import cut_off_homes
from omron_map.text import printable

DONE, FAILED, INTERRUPTED = 0, 1, 130
BACKGROUNDS = {'unknown': UNKNOWN, 'free': FREE}
EPILOGUE = '''exit status:
  0  done; for check: every file loads; for diff: no difference
  1  a file cannot be used, for the reason given; for diff: the maps differ
  2  wrong arguments'''


def main(arguments: Optional[List[str]] = None) -> int:
    """Runs the command and returns its exit status."""
    options = _parser().parse_args(arguments)
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='backslashreplace')  # for letters the terminal cannot show
    try:
        status = options.run(options)
        sys.stdout.flush()
        return status
    except MapError as error:
        print(f'ld_map: {error}', file=sys.stderr)
        return FAILED
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:     # the reader has closed the pipe, as in `ld_map info FILE | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='ld_map', description='Shows, checks and converts .map files of LD robots.',
        epilog=EPILOGUE, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest='command', required=True, metavar='COMMAND')

    command = commands.add_parser('check', help='check whether files load; print warnings')
    command.add_argument('files', nargs='+', metavar='FILE')
    command.set_defaults(run=_check)

    command = commands.add_parser('info', help='show the contents of a map')
    command.add_argument('file', metavar='FILE')
    command.set_defaults(run=_info)

    command = commands.add_parser(
        'export', help='write an occupancy grid for map_server: an image and a .yaml beside it')
    command.add_argument('file', metavar='FILE')
    command.add_argument('output', nargs='?', metavar='OUTPUT',
                         help='image to write, .png or .pgm (default: <FILE>.pgm in the current '
                              'folder)')
    command.add_argument('--resolution', type=_positive, metavar='MM',
                         help="cell size in mm (default: the map's own)")
    command.add_argument('--use', choices=USES, default='auto',
                         help='the occupied cells (default: points if there are any, else lines)')
    command.add_argument('--areas', action='store_true',
                         help='forbidden areas and lines are occupied too')
    command.add_argument('--background', choices=tuple(BACKGROUNDS), default='unknown',
                         help='the value of all other cells (default: unknown)')
    command.set_defaults(run=_export)

    command = commands.add_parser('diff', help='show the differences between two maps')
    command.add_argument('old', metavar='OLD')
    command.add_argument('new', metavar='NEW')
    command.set_defaults(run=_diff)

    command = commands.add_parser('draw', help='draw a picture of a map')
    command.add_argument('file', metavar='FILE')
    command.add_argument('output', nargs='?', metavar='OUTPUT',
                         help='.png file to write (default: <FILE>.png in the current folder)')
    command.add_argument('--size', type=_positive, default=LONG_SIDE, metavar='PIXELS',
                         help=f'longer side of the picture (default: {LONG_SIDE})')
    command.set_defaults(run=_draw)
    return parser


def _positive(text: str) -> int:
    value = int(text)
    if value <= 0:
        raise argparse.ArgumentTypeError(f'{text} is not greater than 0')
    return value


def _check(options: argparse.Namespace) -> int:
    status = DONE
    for path in options.files:
        try:
            document = MapDocument.load(path)
        except MapError as error:
            print(f'ld_map: {error}', file=sys.stderr)
            status = FAILED
            continue
        for warning in (*document.warnings, *cut_off_homes(document)):
            print(f'{path}: warning: {warning}')
        print(f'{path}: ok')
    return status


def _info(options: argparse.Namespace) -> int:
    document = MapDocument.load(options.file)
    print(f'file        {options.file}')
    print(f'category    {document.category}')
    for scan in document.scans:
        if scan.name:
            print(f'scan        {printable(scan.name)}')
        pitch = f'{scan.resolution} mm apart' if scan.resolution else 'on no pitch'
        print(f'points      {len(scan.points)}, {pitch}')
        print(f'lines       {len(scan.lines)}')
    ends = document.points if len(document.points) else document.lines.reshape(-1, 2)
    if len(ends):
        low, high = ends.min(axis=0) / 1000.0, ends.max(axis=0) / 1000.0
        print(f'from, to    ({low[0]:.3f}, {low[1]:.3f}) m, ({high[0]:.3f}, {high[1]:.3f}) m')
    kinds = Counter(printable(obj.kind) for obj in document.objects)
    print(f'objects     {len(document.objects)}'
          + ''.join(f', {kind} {count}' for kind, count in sorted(kinds.items())))
    for obj in document.objects:
        print(f'  {_describe(obj)}')
    print(f'warnings    {len(document.warnings)}')
    for warning in document.warnings:
        print(f'  {warning}')
    return DONE


def _export(options: argparse.Namespace) -> int:
    grid = OccupancyGrid.from_map(
        MapDocument.load(options.file), options.resolution, options.use, options.areas,
        BACKGROUNDS[options.background])
    output = options.output or _beside_us(options.file, '.pgm')
    for path in export_grid(grid, output, is_named=bool(options.output)):
        print(f'wrote {path}')
    return DONE


def _diff(options: argparse.Namespace) -> int:
    difference = compare(MapDocument.load(options.old), MapDocument.load(options.new))
    for obj in difference.removed:
        print(f'- {_describe(obj)}')
    for obj in difference.added:
        print(f'+ {_describe(obj)}')
    for old, new in difference.changed:
        print(f'~ {_describe(old)}: {", ".join(_changes(old, new))}')
    for what, added, removed in (
            ('points', difference.points_added, difference.points_removed),
            ('lines', difference.lines_added, difference.lines_removed)):
        if added or removed:
            print(f'~ {what}: {added} added, {removed} removed')
    return FAILED if difference else DONE


def _draw(options: argparse.Namespace) -> int:
    output = options.output or _beside_us(options.file, '.png')
    width, height = draw_map(MapDocument.load(options.file), output, options.size,
                             is_named=bool(options.output))
    print(f'wrote {output}, {width} x {height} pixels')
    return DONE


def _beside_us(file: str, suffix: str) -> str:
    """Returns the name of `file` with another suffix, in the current folder."""
    return os.path.splitext(os.path.basename(file))[0] + suffix


def _describe(obj: MapObject) -> str:
    """Returns an object in one line: kind, name and position in metres and degrees."""
    text = str(obj)
    if obj.is_area:
        box = obj.rectangle
        return (f'{text} at ({box.centre_x / 1000:.3f}, {box.centre_y / 1000:.3f}) m, '
                f'{box.width / 1000:.3f} x {box.height / 1000:.3f} m, {box.yaw:g} deg')
    if obj.is_line:
        start, end = obj.ends / 1000.0
        return (f'{text} from ({start[0]:.3f}, {start[1]:.3f}) m '
                f'to ({end[0]:.3f}, {end[1]:.3f}) m')
    heading = f', {obj.theta:g} deg' if obj.has_heading else ''
    return f'{text} at ({obj.x / 1000:.3f}, {obj.y / 1000:.3f}) m{heading}'


def _changes(old: MapObject, new: MapObject) -> Iterator[str]:
    """Yields a text for each field that changed."""
    if old.kind != new.kind or old.name != new.name:
        yield f'now {new}'
    if (old.x, old.y, old.theta, old.extent) != (new.x, new.y, new.theta, new.extent):
        yield f'moved to {_describe(new).split(" at ")[-1]}'
    for field in ('description', 'icon', 'tail'):
        if getattr(old, field) != getattr(new, field):
            yield f'other {field}'
