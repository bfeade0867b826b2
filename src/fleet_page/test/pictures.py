"""Makes pictures of the page at four sizes: with 1, 8 and 60 robots, with and without troubles,
with a stopped fleet and with a fleet that drives.

    pictures.py FOLDER [WORD...]    with words: only pictures with one of them in their names
"""
from __future__ import annotations

import itertools
import math
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Callable, Dict

import numpy as np
from browser import Browser, ServedPage
from layout_faults import layout_faults
from page_builders import graph, request, robot, status

from fleet_core.supervision.fleet_stop import FleetStop, StopCause
from fleet_page.core.fleet import (
    ShownAllocation,
    ShownPlan,
    ShownPose,
    ShownResource,
    ShownRobot,
    ShownTemplate,
    ShownTimetable,
    alarm_of,
)
from fleet_page.core.page import Page
from fleet_page.core.records import NamedKind
from fleet_page.core.robot_events import RobotEvent
from fleet_page.core.site import WallMap, wall_map

SIZES = {'phone': (390, 844), 'tablet': (820, 1180), 'desktop': (1440, 900), 'wall': (3840, 2160)}
FLEETS = {1: (4, 3), 8: (6, 4), 60: (16, 9)}  # columns and rows of the graph, by number of robots
TROUBLES = {3: ('FAILED', 'FAILED', 'wheel blocked'), 4: ('STOPPED', 'STOPPED', 'emergency stop'),
            5: ('OFFLINE', 'SILENT', 'it does not report'),
            6: ('OUT_OF_SERVICE', 'OUT_OF_SERVICE', 'it was taken out of service')}
ASKS = ('step 1 (pick) of stop 2 needs an answer: no pallet under the fork. Say `mission answer '
        '1840021807 retry|skip|fail|done`')
WAITS = {2: {'waits_for': 'ld90_1', 'wait': 'TRAFFIC'},
         4: {'waits_for': 'step 1 (pick) of stop 2', 'wait': 'STEP'}}
TABS = ('missions', 'robots', 'edges', 'history', 'replay', 'audit')
VIEWS = (*TABS, 'alarms', 'folded', 'dark', 'german', 'layers', 'template')
CELL = 0.05  # m
AT_REST = '''
    const [frames, done] = arguments, frame = () => new Promise(requestAnimationFrame);
    import('/page/map.js').then(async map => {
        for (let quiet = 0, before = -1; quiet < frames; before = map.framesDrawn()) {
            await frame();
            quiet = map.framesDrawn() === before ? quiet + 1 : 0;
        }
        done();
    });'''


def walls(columns: int, rows: int) -> WallMap:
    """Returns a hall around the graph, with pillars. Its walls are one cell thick."""
    wide, tall = int((3 * columns + 1) / CELL), int((3 * rows + 1) / CELL)
    cells = np.zeros((tall, wide), np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    for x, y in itertools.product(range(columns - 1), range(rows - 1)):
        left, low = int((3.5 + 3 * x) / CELL), int((3.5 + 3 * y) / CELL)
        cells[low - 8:low + 8, left - 8] = cells[low - 8:low + 8, left + 8] = 100
    return wall_map(cells.ravel(), wide, tall, CELL, -2.0, -2.0)


def robots(count: int, in_trouble: bool) -> Dict[str, ShownRobot]:
    """Returns robots of all groups, with missions."""
    found = {}
    for k in range(count):
        state, outage, waits_for = TROUBLES.get(k % 20, ('', '', '')) if in_trouble else ('',) * 3
        kind = k % 4
        found[f'ld90_{k + 1}'] = robot(
            f'ld90_{k + 1}', type='omron_ld90', edge=k + 1, outage=outage or 'NONE',
            state=state or ('IDLE' if kind == 3 else 'CHARGING' if k % 7 == 5 else 'BUSY'),
            battery=0.15 + 0.8 * ((k * 7) % 11) / 11, mission=None if kind == 3 else 1840021800 + k,
            destination=0 if kind == 3 else 2 + k, to_end=None if kind == 3 else 60.0 + 17 * k,
            **{'waits_for': waits_for, **(WAITS.get(k % 8, {}) if not state else {})})
    return found


def show(page: Page, count: int, in_trouble: bool, is_stopped: bool) -> None:
    """Shows a fleet on a page."""
    columns, rows = FLEETS[count]
    now, model = time.time(), page.model
    model.graph = graph(columns, rows)
    page.site.walls, page.site.radii = walls(columns, rows), {'omron_ld90': 0.4}
    page.site.parking = frozenset(range(columns, columns * rows, columns))
    model.site_changed()
    page.records.keep_named(NamedKind.AREA, 'Loading bay', {'edges': [2, 3, 5]})
    model.show_named('areas', page.records.named(NamedKind.AREA))
    model.close_edges([2, 3, 5])
    fleet = robots(count, in_trouble)
    model.update_robots(fleet.values(), now)
    edges = list(model.graph.edges)
    curves = [model.graph.curve(edges[(3 * k) % len(edges)]) for k in range(len(fleet))]
    model.update_places({name: ShownPose(*curve.point_at(1.2), curve.heading_at(1.2))
                       for name, curve in zip(fleet, curves)})
    for k, (name, one) in enumerate(fleet.items()):
        for id, state in ((1840021800 + k, 'ACTIVE' if one.mission else 'PENDING'),
                          (731005200 + 13 * k, ('SUCCEEDED', 'FAILED', 'CANCELLED')[k % 3])):
            made = request(id, 2 + k, 5, 9)
            stamp = int((now - 700 - 31 * k) * 1e9)
            model.note_request(type(made)(id, stamp, made.destinations, '', '', k % 3, 'anna'))
            for became in ('PENDING', state):
                page.update_status(status(
                    id, became, stamp=stamp, serial=4000 + 2 * k + (state != 'ACTIVE'),
                    robot='' if became == 'PENDING' else name,
                    reached=k % 2, reason='wheel blocked' if became == 'FAILED' else ''))
        if in_trouble and k == 7 % count:
            page.update_status(status(1840021800 + k, 'NEEDS_PERSON', stamp=stamp, robot=name,
                                    serial=4000 + 2 * k, reason=ASKS, asks=5))
    page.update_plans({name: ShownPlan((edges[(3 * k) % len(edges)], ), 1)
                     for k, name in enumerate(fleet)}, now)
    model.update_robots(fleet.values(), now)
    for k in range(200):
        if not 90 < k < 110:
            page.records.keep_charges(now - 300 * k, {
                name: abs((0.2 + 0.005 * k) % 1.6 - 0.8) + 0.15 for name in fleet})
    page.records.note_events(
        RobotEvent(now - 4000 + 37 * k, name, one.state, one.outage, one.is_working,
                   alarm_of(one), one.waits_for, one.mission)
        for k, (name, one) in enumerate(itertools.product(fleet, [
            *robots(8, in_trouble).values()][-6:])))
    show_work(page, now)
    show_layers(page, fleet)
    if is_stopped:
        model.show_stop(FleetStop(StopCause.PERSON, 'anna (page)', now - 65))


def show_work(page: Page, now: float) -> None:
    """Shows templates, timetables and a station."""
    page.model.show_templates([ShownTemplate('pallet', ('from', 'to')), ShownTemplate('tour', ())])
    page.model.show_timetables([
        ShownTimetable('to_shelves', 'pallet', (('from', 'press'), ('to', 'shelves')), 30, 360,
                       1080, (0, 1, 2, 3, 4), now + 900),
        ShownTimetable('night tour', 'tour', (), 120, 1320, 1680, tuple(range(7)), None)])
    page.model.show_resources([ShownResource('press', 'STATION', vertices=(9,), robots=('ld90_1',)),
                               ShownResource('gate', 'DOOR', edges=(7,), device='CLOSED')])


def show_layers(page: Page, fleet: Dict[str, ShownRobot]) -> None:
    """Shows entries for all layers of the map, with a laser scan of the first robot."""
    model, edges = page.model, list(page.model.graph.edges)
    model.show_allocations({name: ShownAllocation(tuple(
        (edges[(3 * k + step) % len(edges)], 0.0 if step else 0.3)
        for step in range(1 + k % 2)), 0) for k, name in enumerate(fleet)})
    place = model.places['ld90_1']
    model.show_laser('ld90_1', [round(100 * value) for k in range(-60, 61) for value in (
        place.x + (3.0 + 0.3 * math.sin(k)) * math.cos(0.035 * k),
        place.y + (3.0 + 0.3 * math.sin(k)) * math.sin(0.035 * k))])
    page.site.fences = ((7.0, 1.0, 8.0, 1.0, 8.0, 2.0, 7.0, 2.0), (0.0, 7.2, 6.0, 7.2))
    page.records.add(time.time(), {}, {edge: 10.0 * (k % 9) for k, edge in enumerate(edges)})


def open_view(window: Browser, view: str, frames: int = 40) -> None:
    """Opens one of VIEWS in a window that shows the page, and waits until the map rests.

    frames -- number of frames for which the map must rest
    """
    window.script('''document.documentElement.dataset.theme = arguments[0];
        const language = document.getElementById('language');
        if (arguments[1]) language.value = arguments[1];
        language.dispatchEvent(new Event('change'));
        dispatchEvent(new Event('resize'));''',
                  'dark' if view == 'dark' else 'light', 'de' if view == 'german' else '')
    if view in TABS:
        window.click(f'#tab_button_{view}')
    if view == 'robots':
        window.script("document.getElementById('faults_box').open = true")
    if view in ('robots', 'german'):
        window.click('#tab_button_robots')
        window.click('#robots [data-act=choose]')
        window.one('#robots .curve')
    if view == 'alarms' and window.one('#alarms').is_displayed():
        window.script("""const list = document.getElementById('alarm_list');
            if (list.hidden) document.getElementById('fold_alarms').click();""")
    if view == 'template':
        window.script('''const select = document.getElementById('send_template');
            select.value = 'pallet'; select.dispatchEvent(new Event('change'));
            document.getElementById('timetables_box').open = true;''')
    if view == 'layers':
        window.click('#tab_button_robots')
        window.click('#robots [data-act=choose]')
        window.click('#layers_button')
        for layer in ('allocation', 'laser', 'heat', 'fences'):
            window.click(f'[data-layer={layer}]')
    if view == 'folded':
        window.click('#fold')
    if view == 'dark':
        window.script("document.getElementById('widen').click()")
        window.script("document.getElementById('new_mission').open = false")
    window.wait(lambda: window.text('#open_count'), 'the missions')
    window.driver.execute_async_script(AT_REST, frames)


def make(folder: Path, wanted: Callable[[str], bool]) -> None:
    """Makes the wanted pictures, and prints the faults of each."""
    window = Browser(1440, 900)
    for count, in_trouble, is_stopped in itertools.product(
            FLEETS, (False, True), (False, True)):
        mood = ('stopped_' if is_stopped else '') + ('trouble' if in_trouble else 'calm')
        names = [f'{count}_{mood}_{size}_{view}' for size in SIZES for view in VIEWS]
        if not any(map(wanted, names)):
            continue
        with tempfile.TemporaryDirectory() as own:
            served = ServedPage(Path(own), fill=partial(
                show, count=count, in_trouble=in_trouble, is_stopped=is_stopped))
            for name in filter(wanted, names):
                size, view = name.split('_')[-2:]
                window.resize(*SIZES[size])
                window.open(served.url)
                window.one('.robot')
                open_view(window, view)
                window.driver.save_screenshot(str(folder / f'{name}.png'))
                print(name, *layout_faults(window), *window.problems(), sep='\n    ', flush=True)
                window.script('localStorage.clear()')
            served.close()
    window.close()


if __name__ == '__main__':
    words = sys.argv[2:]
    make(Path(sys.argv[1]), lambda name: not words or any(word in name for word in words))
