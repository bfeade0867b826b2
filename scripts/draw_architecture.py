#!/usr/bin/env python3
"""Draws docs/images/architecture.svg, the picture of the parts in README.

The picture has a light background, so that it is readable even on a dark page.
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
    """A part: its upper left corner and size in px, its name, and what it does."""

    x: int
    y: int
    width: int
    name: str
    does: str
    paint: str
    height: int = 56


class Link(NamedTuple):
    """An arrow from one point to another, and the words beside its middle."""

    start: Tuple[int, int]
    end: Tuple[int, int]
    words: str


BOXES = (
    Box(20, 20, 190, 'People', 'fleet_page, RViz, commands', PEOPLE),
    Box(230, 20, 190, 'Warehouse programs', 'omron_jobs: ARCL, REST', OUTSIDE),
    Box(440, 20, 190, 'Doors, machines', 'fleet_devices: Modbus TCP', OUTSIDE),
    Box(690, 20, 190, 'VDA 5050 master', 'of another maker', OUTSIDE),
    Box(20, 140, 610, 'Fleet manager (graph_fleet_manager, fleet_core)',
        'missions  >  planner  >  interlocking: no robot moves where another one may be', FLEET),
    Box(690, 140, 190, 'vda5050_vehicle', 'in place of a fleet manager', FLEET),
    Box(20, 260, 290, 'AGVs that take routes', 'a driver of your own, or agv_sim', ROBOT),
    Box(340, 260, 540, 'LD-90 driver (omron_ld90)',
        'bridge: routes to drives  >  controller;  status, laser, map in RViz', ROBOT),
    Box(340, 360, 540, 'LD-90, or the simulator ld90_sim', '', OUTSIDE, 30))
LINKS = (
    Link((115, 76), (115, 140), 'missions, stop'), Link((325, 76), (325, 140), 'jobs'),
    Link((535, 140), (535, 76), 'open, start'), Link((785, 76), (785, 140), 'orders, MQTT'),
    Link((165, 196), (165, 260), 'numbered routes'),
    Link((485, 196), (485, 260), 'numbered routes'),
    Link((785, 196), (785, 260), 'routes'), Link((610, 316), (610, 360), 'ARCL over TCP'))


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
