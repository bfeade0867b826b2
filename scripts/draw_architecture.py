#!/usr/bin/env python3
"""Draws docs/images/architecture.svg, the picture of the parts in README.

The picture has its own light ground, so that it can be read on a dark page as well.
"""
from __future__ import annotations

from html import escape
from pathlib import Path
from typing import NamedTuple, Tuple

PICTURE = Path(__file__).resolve().parents[1] / 'docs/images/architecture.svg'
WIDTH, HEIGHT = 900, 400
INK, GROUND = '#1f2937', '#f8fafc'
PEOPLE, FLEET, ROBOT, OUTSIDE = '#dbeafe', '#dcfce7', '#fef3c7', '#e5e7eb'


class Box(NamedTuple):
    """A part: its left upper corner and size in px, its name, and what it does."""

    x: int
    y: int
    width: int
    name: str
    does: str
    paint: str
    height: int = 56


class Link(NamedTuple):
    """A line with an arrow from one point to another, and the words beside its middle."""

    start: Tuple[int, int]
    end: Tuple[int, int]
    words: str


BOXES = (
    Box(20, 20, 200, 'People', 'page, RViz, commands', PEOPLE),
    Box(240, 20, 200, 'Warehouse program', 'jobs by ARCL or REST', OUTSIDE),
    Box(680, 20, 200, 'Doors, machines', 'fleet_devices: Modbus TCP', OUTSIDE),
    Box(20, 150, 860, 'Fleet manager',
        'missions  >  planner  >  interlocking: no robot moves where another one may be', FLEET),
    Box(20, 280, 260, 'LD-90 driver', 'controller, bridge, map in RViz', ROBOT),
    Box(320, 280, 260, 'AGVs that take routes', 'real, or simulated by agv_sim', ROBOT),
    Box(620, 280, 260, 'VDA 5050 adapter', 'for masters of others', ROBOT),
    Box(20, 360, 260, 'LD-90, or ld90_sim', '', OUTSIDE, 30),
    Box(620, 360, 260, 'any VDA 5050 master', '', OUTSIDE, 30))
LINKS = (
    Link((120, 76), (120, 150), 'missions, stop'), Link((340, 76), (340, 150), 'jobs'),
    Link((780, 150), (780, 76), 'open, start'), Link((150, 206), (150, 280), 'numbered routes'),
    Link((450, 206), (450, 280), 'numbered routes'), Link((150, 336), (150, 360), 'ARCL'),
    Link((750, 360), (750, 336), 'MQTT'))


def _box(box: Box) -> str:
    middle = box.x + box.width / 2
    name_at = box.y + (24 if box.does else 20)
    return (f'<rect x="{box.x}" y="{box.y}" width="{box.width}" height="{box.height}" rx="6" '
            f'fill="{box.paint}" stroke="{INK}"/>'
            f'<text x="{middle}" y="{name_at}" font-weight="bold">{escape(box.name)}</text>'
            f'<text x="{middle}" y="{box.y + 44}" font-size="13">{escape(box.does)}</text>')


def _link(link: Link) -> str:
    (x, y), (to_x, to_y) = link.start, link.end
    return (f'<line x1="{x}" y1="{y}" x2="{to_x}" y2="{to_y}" stroke="{INK}" stroke-width="1.5" '
            'marker-end="url(#tip)"/>'
            f'<text x="{(x + to_x) / 2 + 8}" y="{(y + to_y) / 2 + 4}" font-size="12" '
            f'text-anchor="start">{escape(link.words)}</text>')


def drawn() -> str:
    """Returns the picture."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
        f'height="{HEIGHT}" font-family="sans-serif" font-size="15" text-anchor="middle" '
        f'fill="{INK}"><title>The parts of this workspace and what they send to each other</title>'
        '<defs><marker id="tip" markerWidth="9" markerHeight="8" refX="8" refY="4" orient="auto">'
        f'<path d="M0 0 L9 4 L0 8 z" fill="{INK}"/></marker></defs>'
        f'<rect width="{WIDTH}" height="{HEIGHT}" rx="10" fill="{GROUND}"/>'
        + ''.join(map(_box, BOXES)) + ''.join(map(_link, LINKS)) + '</svg>\n')


if __name__ == '__main__':
    PICTURE.write_text(drawn(), encoding='utf-8')
