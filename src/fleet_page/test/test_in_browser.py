"""The page in a real Chromium.

The tests follow each act from the click to the fleet. They also check languages, sizes and the
keyboard.
"""
from __future__ import annotations

import colorsys
import time
from dataclasses import replace
from functools import partial
from itertools import combinations
from random import Random

import pytest

pytest.importorskip('aiohttp')

from browser import Browser, ServedPage, needs_browser  # noqa: E402
from layout_faults import layout_faults  # noqa: E402
from page_builders import TOKENS, robot, status  # noqa: E402
from pictures import open_view, show, walls  # noqa: E402

from fleet_core.supervision.fleet_stop import (  # noqa: E402
    NOT_STOPPED,
    FleetStop,
    StopCause,
)
from fleet_page.core.acts import ActKind  # noqa: E402
from fleet_page.core.fleet import (  # noqa: E402
    ShownAllocation,
    ShownMachine,
    ShownPose,
    ShownQueuePlace,
    ShownResource,
    ShownTemplate,
    ShownTimetable,
)
from fleet_page.core.records import NamedKind  # noqa: E402
from trajectory_graph import split_edges  # noqa: E402
from trajectory_graph.placing import (  # noqa: E402
    ABOVE_FIRST,
    MayCover,
    Places,
    box_around,
    box_beside,
    shared,
)

pytestmark = needs_browser
MISSION = '#open tr[data-key^="7:"]'


@pytest.fixture(scope='module')
def browser():
    window = Browser()
    yield window
    window.close()


@pytest.fixture
def served(tmp_path):
    shown = ServedPage(tmp_path)
    yield shown
    shown.close()


@pytest.fixture
def window(browser, served):
    browser.resize(1400, 900)
    browser.open(served.url)
    browser.one('.robot[data-name=a]')
    browser.wait(lambda: 'wheel blocked' in browser.text('#alarms'))
    browser.addresses()
    browser.problems()
    yield browser
    outside = [url for url in browser.addresses()
               if not url.startswith((served.url, 'data:', 'chrome'))]
    assert outside == [] and browser.problems() == []


def asked(window, served, kind, **values):
    """Returns the act of this kind that arrived at the fleet, and checks its values."""
    act = window.wait(lambda: next((act for act, _ in served.fleet.acts if act.kind is kind), None),
                      kind.value)
    for name, value in values.items():
        assert getattr(act, name) == value
    return act


def test_robots_missions_alarms_and_plans_are_shown(window, served):
    assert 'a 75 %' in window.text('.robot[data-name=a]')
    assert window.one('.released[data-robot=a]')
    window.wait(lambda: 'wheel blocked' in window.text('#alarms'), 'the alarm')
    window.wait(lambda: '▶2 → 3' in window.text('#open'), 'the mission')
    assert window.one('#ended tr')
    window.picture('live')


def test_a_robot_that_moves_is_drawn_where_it_is(window, served):
    before = window.one('.robot[data-name=a]').get_attribute('transform')
    served.do(lambda: served.page.model.update_places({'a': ShownPose(2.5, 0.0, 0.0)}))
    window.wait(lambda: window.one('.robot[data-name=a]').get_attribute('transform') != before)


def test_a_door_and_a_station_are_drawn_with_words_for_what_they_show(window, served):
    def show(*resources):
        served.do(lambda: served.page.model.show_resources(resources))
    press, door = ShownResource('press', 'STATION', vertices=(6,), robots=('a',)), ShownResource(
        'gate', 'DOOR', edges=(8,), device='CLOSED', look='SHUT')
    show(press, door)
    window.wait(lambda: window.text('.resource[data-name=gate] text') == 'door gate: closed')
    assert window.one('.resource[data-name=gate] path')
    assert window.one('.resource[data-name=press] circle')
    assert window.text('.resource[data-name=press] text') == 'station press'
    named = window.one('.resource[data-name=press]').get_attribute('aria-label')
    assert named == 'station press (a)'
    window.picture('resources')
    show(press, replace(door, device='OPEN', look='OPEN'))
    window.wait(lambda: window.text('.resource[data-name=gate] text') == 'door gate: open')
    show()
    window.wait(lambda: not window.driver.find_elements('css selector', '.resource'))


def test_queue_places_have_their_order_and_their_robots_and_machines_their_state(window, served):
    queue = (ShownQueuePlace(7, 'a', True), ShownQueuePlace(8, 'b'), ShownQueuePlace(12))
    served.do(lambda: served.page.model.show_resources(
        [ShownResource('press', 'STATION', vertices=(6,), queue=queue)],
        [ShownMachine('press_1', 'WORKING', 'OPEN', (6,), 'a'),
         ShownMachine('oven', 'SILENT', 'TROUBLE')]))
    window.one('.machine[data-name=press_1] rect')
    assert [one.get_attribute('aria-label') for one in window.driver.find_elements(
        'css selector', '.queue')] == ['press 1: a', 'press 2: b is on its way', 'press 3']
    assert window.text('.queue.TAKEN text') == 'press 1: a'
    assert window.one('.machine').get_attribute('aria-label') == 'machine press_1: working (a)'
    assert not window.driver.find_elements('css selector', '.machine[data-name=oven]')
    covered = window.script('''return [...document.querySelectorAll('.resource text')].map(
        text => text.getBoundingClientRect()).map(box => [box.left, box.top, box.right, box.bottom])
    ''')
    assert len(covered) > 3
    assert not any(shared(one, other) > 4.0 for one, other in combinations(covered, 2))
    window.picture('queue')
    served.do(lambda: served.page.model.show_resources([]))
    window.wait(lambda: not window.driver.find_elements('css selector', '.resource'))


def test_a_group_is_a_destination_by_its_name_in_the_form_and_on_the_map(window, served):
    served.do(lambda: served.page.model.show_resources([
        ShownResource('shelves', 'STATION', vertices=(10, 11), is_group=True),
        ShownResource('table', 'STATION', vertices=(3, 4)),
        ShownResource('2nd', 'STATION', vertices=(7,))]))
    window.wait(lambda: [one.get_attribute('value') for one in window.driver.find_elements(
        'css selector', '#places option')][:2] == ['2nd', 'shelves'])
    for word in ('shelves', '2nd', '1 dock', '5'):
        window.one('#destination').send_keys(word)
        window.click('#add')
    window.click_words('.station[data-name=shelves] text')
    window.one('#destination').send_keys('table')
    window.click('#add')
    window.wait(lambda: window.text('#said') == 'There is no such destination.')
    assert [one.text.split(' ')[0] for one in window.driver.find_elements(
        'css selector', '#chosen li')] == ['shelves', '2nd', '1', '5', 'shelves']
    window.picture('group')
    window.click('#send_button')
    act = asked(window, served, ActKind.SEND)
    assert act.destinations == ('shelves', '2nd', 1, 5, 'shelves')


def test_a_load_is_drawn_on_its_robot_and_its_mission_is_in_the_list(window, served):
    def carry(**load):
        served.do(lambda: served.page.model.update_robots(
            [robot(**load), robot('b', mission=None, load='UNKNOWN')], time.time()))
    carry(load='LOADED', load_serial=42)
    window.wait(lambda: 'load of M42' in window.one('.robot[data-name=a]').get_attribute(
        'aria-label'))
    assert window.one('.robot[data-name=a] .load').is_displayed()
    window.click('#tab_button_robots')
    window.wait(lambda: '· load of M42' in window.text('#robots [data-key=a]'))
    assert window.text('#robots [data-key=b] .bad').strip() == '· load unknown'
    trouble = window.script('''return ['b', 'a'].map(name => getComputedStyle(
        document.querySelector(`.robot[data-name=${name}] .load`)).fill)''')
    assert trouble[0] == 'rgb(179, 22, 27)' != trouble[1]
    window.picture('loads')
    carry(load='UNKNOWN', load_types=('pallet',), state='BUSY', wait='STEP')
    window.wait(lambda: '· load is being moved (pallet)' in window.text('#robots [data-key=a]'))
    assert not window.driver.find_elements('css selector', '#robots [data-key=a] .bad')
    carry()
    window.wait(lambda: not window.one('.robot[data-name=a] .load').is_displayed())


def test_the_page_places_texts_by_the_same_rules_as_rviz_and_the_editor(window, served):
    draw = Random(7)
    cases = []
    for _ in range(60):
        covers = [(box_around((draw.uniform(0, 300), draw.uniform(0, 200)),
                              (draw.uniform(5, 90), draw.uniform(5, 40))), draw.random() < 0.5)
                  for _ in range(draw.randrange(12))]
        texts = [(draw.uniform(0, 300), draw.uniform(0, 200), draw.uniform(2, 20),
                  draw.uniform(10, 90), draw.uniform(8, 40), draw.choice(list(MayCover)),
                  draw.choice([-1, -1, *range(8)])) for _ in range(8)]
        cases.append((covers, texts))
    asked = [([(box, is_soft) for box, is_soft in covers], [
        {'x': x, 'y': y, 'away': away, 'width': width, 'height': height, 'before': before,
         'may': {MayCover.NOTHING: '', MayCover.SOFT: 'soft', MayCover.ALL: 'all'}[may]}
        for x, y, away, width, height, may, before in texts]) for covers, texts in cases]
    window.driver.set_script_timeout(20)
    told = window.driver.execute_async_script('''
        const [cases, done] = arguments;
        import('/page/placing.js').then(({ ABOVE_FIRST, Places }) => done(cases.map(
            ([covers, texts]) => {
                const places = new Places(300, 200);
                for (const [box, isSoft] of covers) places.cover(box, isSoft);
                return texts.map(text => places.place(text, ABOVE_FIRST, text.before));
            })));''', asked)
    down_first = [(right, -up) for right, up in ABOVE_FIRST]  # y of the page is downwards
    for (covers, texts), page in zip(cases, told):
        places = Places((0.0, 0.0, 300.0, 200.0), 64.0)
        for box, is_soft in covers:
            places.cover(box, is_soft)
        assert page == [places.place(
            [box_beside((x, y), away, (width, height), side) for side in down_first], before, may)
            for x, y, away, width, height, may, before in texts]


def test_the_header_counts_robots_and_missions_and_opens_their_lists(window, served):
    def count(name):
        return window.text(f'#counts [data-act={name}] b')
    window.wait(lambda: (count('driving'), count('trouble'), count('open'), count('done'))
                == ('1', '1', '2', '1'))
    window.click('#counts [data-act=trouble]')
    window.wait(lambda: [row.get_attribute('data-key') for row in window.driver.find_elements(
        'css selector', '#robots > li')] == ['b'])
    window.click('#counts [data-act=open]')
    assert window.one('#tab_missions').is_displayed()


def test_the_panel_folds_away_for_the_map_and_stays_so_after_a_reload(window, served):
    def width():
        return window.script("return document.getElementById('map').clientWidth")
    open_width = width()
    try:
        window.click('#fold')
        window.wait(lambda: width() > open_width and not window.one('#panel').is_displayed())
        window.open(served.url)
        window.one('.robot[data-name=a]')
        assert not window.one('#panel').is_displayed()
        window.click('#tab_button_robots')
        window.wait(lambda: window.one('#robots').is_displayed())
        window.click('#widen')
        window.wait(lambda: width() < open_width)
    finally:
        window.script('localStorage.clear()')


WHOLE = '''
const [scales, done] = arguments;
const frame = document.createElement('canvas'), image = new Image();
frame.width = frame.height = 1400;
image.onload = async () => {
    const { Walls } = await import('/page/walls.js');
    const site = await (await fetch('/api/site')).json();
    const walls = new Walls(image, site.map), [x, y, width, height] = site.map;
    done([walls.bounds, scales.map(scale => {
        const paint = frame.getContext('2d', { willReadFrequently: true });
        paint.clearRect(0, 0, 1400, 1400);
        const pixel = (px, py) => [20 + (px - x) * scale, 20 + (y + height - py) * scale];
        walls.draw(paint, pixel, scale, 1);
        const has = (px, py) => paint.getImageData(px - 1, py - 1, 3, 3).data.some(value => value);
        const right = Math.round(width * scale), low = Math.round(height * scale);
        let gaps = 0;
        for (let k = 2; k < right - 2; k++) gaps += !has(20 + k, 20) + !has(20 + k, 19 + low);
        for (let k = 2; k < low - 2; k++) gaps += !has(20, 20 + k) + !has(19 + right, 20 + k);
        return gaps;
    })]);
};
image.src = '/api/map.png';'''


def test_walls_of_one_cell_are_whole_at_every_zoom(window, served):
    def build():
        served.page.site.walls = walls(14, 14)  # 43 m with cells of 0.05 m
        served.page.model.site_changed()
    served.do(build)
    scales = [0.7, 1.0, 2.3, 4.9, 7.0, 11.0, 19.9, 20.0, 31.0]
    bounds, gaps = window.driver.execute_async_script(WHOLE, scales)
    assert gaps == [0] * len(scales)
    assert bounds == pytest.approx([-2.0, -2.0, 41.0, 41.0], abs=43 / 32)


def test_a_robot_has_the_colour_that_it_has_in_rviz(window, served):
    drawing = pytest.importorskip('rviz_drawing.drawing')
    served.do(lambda: served.page.model.update_robots(
        [robot(name) for name in ('a', 'b', 'c', 'd')], time.time()))
    for number, name in enumerate('abcd'):
        own = drawing.own_colour(number)
        hue = 360.0 * colorsys.rgb_to_hsv(own.r, own.g, own.b)[0]
        shown = window.one(f'.robot[data-name={name}] .body').get_attribute('fill')
        assert float(shown[4:].split()[0]) == pytest.approx(hue, abs=0.1), name


OVERLAPS = '''
const texts = [...document.querySelectorAll('.robot text')];
const boxes = texts.map(text => text.getBoundingClientRect()); // as high as a line of the font
const cover = (one, other) => one.left < other.right && other.left < one.right &&
    one.top + 4 < other.bottom && other.top + 4 < one.bottom;
return boxes.filter((one, k) => boxes.slice(k + 1).some(other => cover(one, other))).length;'''


def test_the_labels_of_robots_that_meet_do_not_cover_each_other(window, served):
    names = [f'ld90_{k}' for k in range(5)]
    served.do(lambda: (
        served.page.model.update_robots([robot(name, battery=None) for name in names], time.time()),
        served.page.model.update_places({
            name: ShownPose(4.0 + 0.9 * (k % 3), 3.0 + 0.9 * (k // 3), 0.0)
            for k, name in enumerate(names)})))
    window.wait(lambda: len(window.driver.find_elements('css selector', '.robot text')) == 5)
    window.wait(lambda: window.script(OVERLAPS) == 0, 'labels without overlaps')
    window.picture('labels')


COVERED = '''
const robots = [...document.querySelectorAll('#moving .robot')];
const cover = (one, other) => one.left + 1 < other.right && other.left + 1 < one.right &&
    one.top + 5 < other.bottom && other.top + 5 < one.bottom; // texts are as high as a line
const box = (robot, part) => robot.querySelector(part).getBoundingClientRect();
const named = robots.filter(robot => box(robot, 'text').width);
return [named.map(robot => robot.dataset.name), named.filter(robot => robots.some(other =>
    other !== robot && (cover(box(robot, 'text'), box(other, '.body')) ||
        (named.includes(other) && cover(box(robot, 'text'), box(other, 'text')))))).length];'''


def test_a_robot_in_a_crowd_has_its_name_where_that_covers_no_other_robot(window, served):
    names = [f'ld90_{k}' for k in range(24)]
    window.resize(390, 844)
    served.do(lambda: (
        served.page.model.update_robots([robot(name, battery=None) for name in names], time.time()),
        served.page.model.update_places({name: ShownPose(1.6 * (k % 6), 1.6 * (k // 6), 0.0)
                                       for k, name in enumerate(names)})))

    def shown():
        named, covering = window.script(COVERED)
        return 0 if covering else len(named)
    window.wait(lambda: len(window.driver.find_elements(
        'css selector', '#moving .robot')) == 24 and 8 <= shown() < 24, 'the names')
    left_out = next(name for name in names if name not in window.script(COVERED)[0])
    served.do(lambda: served.page.model.update_robots([robot(name, battery=None, **(
        {'state': 'FAILED', 'outage': 'FAILED'} if name == left_out else {}))
        for name in names], time.time()))
    window.wait(lambda: left_out in window.script(COVERED)[0], 'the name of the robot in trouble')


BESIDE = '''
const done = arguments[0];
import('/page/map.js').then(map => {
    const buttons = document.getElementById('zoom_in').parentElement.getBoundingClientRect();
    const around = document.getElementById('map').getBoundingClientRect();
    const [[x, y], [right, high]] = [map.screenPlace(1), map.screenPlace(12)]; // 9 m, 6 m
    const metre = (right - x) / 9, wall = { right: right + 2 * metre, low: y + 2 * metre };
    done(x - 2 * metre > around.left && high - 2 * metre > around.top &&
         (wall.right < buttons.left || wall.low < buttons.top) && buttons.top > around.top);
});'''


def test_the_buttons_of_the_map_do_not_cover_the_site(window, served):
    def build():
        served.page.site.walls = walls(4, 3)  # with a margin of 2 m around the graph
        served.page.model.site_changed()
    served.do(build)
    for width, height in ((390, 844), (820, 1180), (1440, 900), (844, 390)):
        window.resize(width, height)
        window.wait(lambda: window.driver.execute_async_script(BESIDE), f'{width} x {height}')  # noqa: B023


CROWDS = '''
const done = arguments[0];
import('/page/placing.js').then(({ Places, boxOf, BELOW_RIGHT_FIRST }) => {
    let covered = 0, shown = 0;
    for (let seed = 1; seed < 100; seed++) {
        let state = seed;
        const next = () => (state = state * 16807 % 2147483647) / 2147483647;
        const places = new Places(800, 600), boxes = [];
        for (let k = 0; k < 60; k++) {
            const text = { x: next() * 800, y: next() * 600, away: 5, width: 20 + 40 * next(),
                           height: 12 };
            const side = places.place(text, BELOW_RIGHT_FIRST);
            if (side >= 0) boxes.push(boxOf(text, BELOW_RIGHT_FIRST[side]));
        }
        shown += boxes.length;
        for (const [k, a] of boxes.entries())
            for (const b of boxes.slice(k + 1))
                covered += Math.min(a[2], b[2]) - Math.max(a[0], b[0]) > 1e-6 &&
                    Math.min(a[3], b[3]) - Math.max(a[1], b[1]) > 1e-6;
    }
    done([covered, shown]);
});'''


def test_no_name_of_a_crowd_covers_another_and_most_are_shown(window, served):
    covered, shown = window.driver.execute_async_script(CROWDS)
    assert covered == 0 and shown > 0.8 * 99 * 60


def test_people_say_a_short_name_and_see_the_id_of_the_request_beside_it(window, served):
    served.do(lambda: served.page.update_status(
        status(7, 'NEEDS_PERSON', serial=42, reason=ASKS, asks=STEP)))
    window.wait(lambda: 'Mission M42 (7) a: step 1' in window.text('#alarms'))
    name = f'{MISSION} .id'
    assert (window.text(f'{name} span'), window.text(f'{name} small')) == ('M42', '7')
    window.one('#mission_search').send_keys('m42')
    window.wait(lambda: shown_missions(window) == ['7'])
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    window.wait(lambda: 'M42 · needs a person' in window.text('#robots'))
    assert 'agv · Mission M42' in window.text('#robots')


def test_a_list_that_changes_while_a_language_is_loaded_is_in_that_language_afterwards(
        window, served):
    window.script('''const real = window.fetch, language = document.getElementById('language');
        const released = new Promise(done => { window.release = done; });
        window.fetch = async (path, ...more) => {
            if (String(path).endsWith('de.json')) await released;
            return real(path, ...more);
        };
        language.value = 'de'; language.dispatchEvent(new Event('change'));''')
    served.do(lambda: served.page.model.update_robots([robot('a', wait='STEP')], time.time()))
    window.wait(lambda: window.text('#counts [data-act=working] b') == '1')
    window.script('window.release()')
    window.wait(lambda: 'Auftr' in window.text('#tab_button_missions'))
    window.wait(lambda: 'arbeiten' in window.text('#counts'))
    window.script('localStorage.clear()')


@pytest.mark.parametrize('width, height', [(390, 844), (820, 1180)])
def test_the_answer_to_an_act_covers_no_tab(window, served, width, height):
    window.resize(width, height)
    window.click('#stop')
    window.wait(lambda: window.one('#said').is_displayed())
    for tab in ('robots', 'missions'):
        window.one(f'#tab_button_{tab}').click()
        assert window.one(f'#tab_{tab}').is_displayed() and window.one('#said').is_displayed()


def test_a_chosen_robot_shows_its_battery_its_missions_and_what_happened_to_it(window, served):
    begun = time.time() - 3600.0

    def fill():
        for k in range(12):
            served.page.records.keep_charges(begun + 300 * k, {'a': 0.9 - 0.01 * k})
    served.do(fill)
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    window.one('#robots .curve .line')
    assert '75 % now, lowest 75 %' in window.text('#robots')
    assert '9 · done' in window.text('#robots') and 'Nothing has happened' in window.text('#robots')
    assert 'Software' not in window.text('#robots'), 'the robot has told none'
    served.do(lambda: served.page.model.update_robots([robot(
        'a', state='STOPPED', outage='STOPPED', waits_for='emergency stop', software='own 2.1')],
        time.time()))
    window.wait(lambda: 'emergency stop · Mission 7' in window.text('#robots .lines .bad'))
    assert 'agv · Software own 2.1 · Mission 7' in window.text('#robots')
    window.picture('robot')


def test_the_list_of_faults_names_every_robot_that_does_not_work_with_code_and_remedy(
        window, served):
    served.do(lambda: served.page.model.update_robots([
        robot('a'), robot('b', state='FAILED', outage='FAILED', waits_for='wheel blocked'),
        robot('c', state='OUT_OF_SERVICE', outage='OUT_OF_SERVICE', mission=None)], time.time()))
    window.click('#tab_button_robots')
    window.click('#faults_box summary')
    window.wait(lambda: '(2)' in window.text('#faults_box summary'))
    for row, words in (('b', ('FAILED', 'wheel blocked', 'since', 'Look at the robot')),
                       ('c', ('OUT_OF_SERVICE', 'taken out of service', 'put it into service'))):
        text = window.text(f'#faults [data-key={row}]')
        assert all(word in text for word in words), text
    window.click('#faults [data-key=b] [data-act=choose]')
    window.one('#robots li.chosen[data-key=b]')
    window.script('localStorage.clear()')


def test_a_robot_at_a_step_works_in_words_and_in_the_counts(window, served):
    served.do(lambda: served.page.model.update_robots([
        robot('a', waits_for='step 1 (pick) of stop 2', wait='STEP'),
        robot('b', waits_for='a', wait='TRAFFIC')], time.time()))
    window.click('#tab_button_robots')
    window.wait(lambda: 'works at 2: step 1 (pick) of stop 2' in window.text('#robots'))
    assert 'drives to 2 (waits for: a)' in window.text('#robots')
    window.wait(lambda: [window.text(f'#counts [data-act={name}] b') for name in (
        'working', 'waiting', 'driving')] == ['1', '1', '0'])


def test_the_map_follows_a_robot_until_the_user_moves_it(window, served):
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    window.click('#robots li[data-key=a] [data-act=follow]')

    def from_middle():
        return window.script('''
            const map = document.getElementById('map').getBoundingClientRect();
            const at = document.querySelector('.robot[data-name=a] .ring').getBoundingClientRect();
            return Math.hypot((at.left + at.right - map.left - map.right) / 2,
                              (at.top + at.bottom - map.top - map.bottom) / 2);''')
    for x in (1.5, 7.0):
        served.do(lambda: served.page.model.update_places({'a': ShownPose(x, 4.0, 0.0)}))  # noqa: B023
        window.wait(lambda: from_middle() < 3.0)
    window.click('#zoom_fit')
    window.wait(lambda: from_middle() > 20.0)
    assert window.one('[data-act=follow]').get_attribute('aria-pressed') == 'false'


def test_an_alarm_sounds_until_a_person_has_seen_it_and_stays_until_its_cause_is_gone(
        window, served):
    def sounds():
        return window.driver.execute_async_script(
            "import('/page/alarms.js').then(alarms => arguments[0](alarms.isSounding()));")
    window.click('#tab_button_robots')  # a browser plays no sound before a click
    window.wait(sounds)
    window.click('#sound')
    assert not sounds()
    window.click('#sound')
    assert sounds()
    window.click('#alarm_list [data-act=acknowledge]')
    window.wait(lambda: 'seen by local' in window.text('#alarms'))
    assert not sounds() and 'wheel blocked' in window.text('#alarms')
    served.do(lambda: served.page.model.update_robots([robot('a'), robot(
        'b', state='STOPPED', outage='STOPPED', waits_for='emergency stop')], time.time()))
    window.wait(lambda: sounds() and 'seen by' not in window.text('#alarms'), 'the next cause')
    served.do(lambda: served.page.model.update_robots([robot('a'), robot('b')], time.time()))
    window.wait(lambda: not window.one('#alarms').is_displayed())


PLACES = '''
    const done = arguments[0], frame = () => new Promise(requestAnimationFrame);
    import('/page/map.js').then(async map => {
        for (let k = 0; k < 3; k++) await frame();
        done([map.screenPlace(1), map.screenPlace(12), ...[...document.querySelectorAll(
            'header button, #rail button, #zoom button, #tab_robots summary')].map(button => {
                const box = button.getBoundingClientRect();
                return [button.id || button.dataset.act, box.left, box.top];
            })]);
    });'''


@pytest.mark.parametrize('width, height, folded', [(390, 844, True), (1440, 900, False)])
def test_news_move_neither_the_map_nor_a_button_under_a_finger(
        window, served, width, height, folded):
    window.resize(width, height)
    window.click('#tab_button_robots')
    if folded:
        window.click('#fold')
    places = window.driver.execute_async_script(PLACES)
    served.do(lambda: served.page.model.update_robots([robot('a'), robot('b')], time.time()))
    window.wait(lambda: not window.one('#alarms').is_displayed())
    assert window.driver.execute_async_script(PLACES) == places, 'the last alarm has gone'
    ask(served)
    window.wait(lambda: 'no pallet' in window.text('#alarms'))
    assert window.driver.execute_async_script(PLACES) == places, 'an alarm has come'
    stop_the_fleet(window, served)
    assert window.driver.execute_async_script(PLACES) == places, 'the fleet is stopped'
    served.die()
    window.wait(lambda: 'does not answer' in window.text('#old_state'))
    window.picture(f'news_{width}_{"folded" if folded else "open"}')
    assert window.driver.execute_async_script(PLACES) == places, 'the fleet manager is silent'
    window.script('localStorage.clear()')


def shown_missions(window):
    return [row.get_attribute('data-key').split(':')[0] for row in window.driver.find_elements(
        'css selector', '#open > tr')]


def test_missions_are_searched_filtered_and_sorted(window, served):
    served.do(lambda: served.page.update_status(status(8, 'PENDING', robot='', reason='no way')))
    window.wait(lambda: shown_missions(window) == ['7', '8'])
    window.one('#mission_search').send_keys('NO WAY')
    window.wait(lambda: shown_missions(window) == ['8'])
    assert '(1 of 2)' in window.text('#open_count')
    window.one('#mission_search').clear()
    window.one('#mission_search').send_keys(' ')
    window.script('''const state = document.getElementById('mission_state');
        state.value = 'ACTIVE'; state.dispatchEvent(new Event('change'));''')
    window.wait(lambda: shown_missions(window) == ['7'])
    window.script('''const state = document.getElementById('mission_state');
        state.value = ''; state.dispatchEvent(new Event('change'));''')
    try:
        window.click('#widen')
        window.click('thead [data-order=id]')
        window.click('thead [data-order=id]')
        window.wait(lambda: shown_missions(window) == ['8', '7'])
        assert window.one('thead th.id').get_attribute('aria-sort') == 'descending'
        window.picture('wide')
    finally:
        window.script('localStorage.clear()')


def test_the_menu_of_a_mission_works_by_keyboard_and_outlives_news(window, served):
    from selenium.webdriver.common.keys import Keys
    window.one(f'{MISSION} [data-act=menu]').send_keys(Keys.ENTER)
    window.wait(lambda: window.one('#menu').is_displayed())
    served.do(lambda: served.page.update_status(status(7, 'ACTIVE', reached=1, reason='news')))
    window.wait(lambda: 'news' in window.text('#open'))
    window.driver.switch_to.active_element.send_keys(Keys.ARROW_DOWN)
    window.driver.switch_to.active_element.send_keys(Keys.ESCAPE)
    assert not window.one('#menu').is_displayed()
    assert window.script("return document.activeElement.dataset.act") == 'menu'
    window.driver.switch_to.active_element.send_keys(Keys.ENTER)
    window.driver.switch_to.active_element.send_keys(Keys.ARROW_UP)
    window.driver.switch_to.active_element.send_keys(Keys.ENTER)
    asked(window, served, ActKind.CANCEL, mission=7)


def test_the_stop_button_stops(window, served):
    window.click('#stop')
    asked(window, served, ActKind.STOP)
    window.wait(lambda: 'stop was asked' in window.text('#said'))
    window.click('#resume')
    asked(window, served, ActKind.RESUME)


BAR = 'THE FLEET IS STOPPED since '


def stopped_words(window):
    """Returns the words of the red bar; empty if the bar is not shown."""
    return window.script('''const bar = document.getElementById('stopped');
        return bar.hidden ? '' : bar.textContent;''')


def stop_the_fleet(window, served, by='anna (page)', why=''):
    served.do(lambda: served.page.model.show_stop(
        FleetStop(StopCause.PERSON, by, time.time(), why)))
    window.wait(lambda: BAR in stopped_words(window), 'the bar')


def test_a_stopped_fleet_says_so_until_it_goes_on(window, served):
    assert stopped_words(window) == '' and window.driver.title == 'Fleet'
    stop_the_fleet(window, served)
    assert ', by anna (page). It stands until a person presses Go on.' in stopped_words(window)
    assert window.driver.title == 'STOPPED – Fleet'
    window.wait(lambda: 'stands, the fleet is stopped 7' in window.text('#open'), 'the mission')
    assert 'to go' not in window.text('#open') and 'under way' not in window.text('#open')
    window.picture('stopped')
    window.click('#resume')
    asked(window, served, ActKind.RESUME)
    assert stopped_words(window), 'the answer of a request is not yet the state of the fleet'
    served.do(lambda: served.page.model.show_stop(NOT_STOPPED))
    window.wait(lambda: stopped_words(window) == '' and window.driver.title == 'Fleet')
    window.wait(lambda: 'under way 7' in window.text('#open'))


ASKS = ('step 1 (pick) of stop 2 needs an answer: no pallet. '
        'Say `mission answer 7 retry|skip|fail|done`')
STEP = 2 ** 63 + 1


def ask(served, state='NEEDS_PERSON', reason=ASKS):
    served.do(lambda: served.page.update_status(status(7, state, reason=reason, asks=STEP)))


def test_a_mission_that_needs_a_person_is_told_below_the_lists_until_it_goes_on(window, served):
    ask(served)
    window.wait(lambda: 'Mission 7 a: step 1 (pick) of stop 2 needs an answer: no pallet'
                in window.text('#alarms'))
    stop_the_fleet(window, served)
    window.wait(lambda: 'needs a person 7' in window.text('#open'))
    window.picture('needs_person_stopped')
    window.script("document.getElementById('language').value = 'de';"
                  "document.getElementById('language').dispatchEvent(new Event('change'))")
    window.wait(lambda: 'Auftrag 7 a: Schritt 1 (pick) der Station 2 braucht eine Antwort: no '
                        'pallet' in window.text('#alarms'))
    window.script('localStorage.clear()')
    served.do(lambda: served.page.update_status(status(7)))
    window.wait(lambda: 'Auftrag 7' not in window.text('#alarms'))
    assert 'wheel blocked' in window.text('#alarms')


@pytest.mark.parametrize('place', ['#alarms', MISSION])
@pytest.mark.parametrize('answer', ['retry', 'skip', 'fail', 'done'])
def test_a_step_that_asks_is_answered_by_a_button(window, served, place, answer):
    ask(served)
    window.click(f'{place} [data-act=answer_{answer}]')
    asked(window, served, ActKind.ANSWER, mission=7, answer=answer, step=STEP)


@pytest.mark.parametrize('language', ['en', 'de'])
@pytest.mark.parametrize('state, reason', [
    ('NEEDS_PERSON', ASKS),
    ('ACTIVE', 'step 1 (pick) of stop 2 by a person: say `mission answer 7 done`'),
    ('ACTIVE', 'step 1 (pick) of stop 2 by a program: it says `mission answer 7 done`')])
def test_beside_the_buttons_of_a_step_stands_no_command_that_does_the_same(
        window, served, state, reason, language):
    window.script("""const language = document.getElementById('language');
        language.value = arguments[0]; language.dispatchEvent(new Event('change'));""", language)
    ask(served, state, reason)
    asks = {'en': 'step 1 (pick) of stop 2', 'de': 'Schritt 1 (pick) der Station 2'}[language]
    window.wait(lambda: asks in window.text(MISSION))
    window.script('localStorage.clear()')
    assert 'mission answer' not in window.text(MISSION) + window.text('#alarms')


@pytest.mark.parametrize('width, height', [(390, 844), (820, 1180), (1440, 900), (2560, 1440)])
def test_each_button_of_two_alarms_is_in_view(window, served, width, height):
    ask(served, reason=ASKS.replace('no pallet', 'the fork saw no pallet where one should be')
        .replace('answer 7', 'answer 1840021807'))
    window.resize(width, height)
    window.script("localStorage.setItem('alarms', 'open')")
    window.driver.refresh()
    window.one('#alarms [data-act=answer_done]')
    hidden = window.script("""
        const list = document.getElementById('alarm_list').getBoundingClientRect();
        return [...document.querySelectorAll('#alarm_list button')].filter(button =>
            button.getBoundingClientRect().bottom > list.bottom).map(button => button.textContent);
        """)
    window.script('localStorage.clear()')
    window.picture(f'alarms_{width}')
    assert hidden == []


@pytest.mark.parametrize('width, height', [(390, 844), (820, 1180)])
def test_the_open_list_of_alarms_leaves_room_for_the_map_and_a_tab_brings_the_panel_back(
        window, served, width, height):
    window.resize(width, height)
    served.do(lambda: served.page.model.update_robots(
        [robot(f'r{k}', state='FAILED', outage='FAILED') for k in range(60)], time.time()))
    window.wait(lambda: '(60)' in window.text('#alarm_count'))
    window.click('#fold_alarms')
    assert window.one('#alarm_list').is_displayed()
    assert window.one('#map').rect['height'] > 200
    buttons = [window.one(name).rect for name in ('#sound', '#fold_alarms')]
    assert buttons[0]['y'] == buttons[1]['y']
    window.click('#tab_button_robots')
    assert window.one('#robots').is_displayed() and not window.one('#alarm_list').is_displayed()
    window.script('localStorage.clear()')


def test_a_step_that_a_person_does_is_ended_by_a_button_and_cannot_be_tried_again(window, served):
    assert not window.driver.find_elements('css selector', '[data-act^=answer_]')
    ask(served, 'ACTIVE', 'step 1 (pick) of stop 2 by a person: say `mission answer 7 done`')
    window.click('#open [data-act=answer_done]')
    asked(window, served, ActKind.ANSWER, answer='done', step=STEP)
    assert not window.driver.find_elements('css selector', '[data-act=answer_retry]')


def test_the_stop_is_told_after_a_reload_and_in_a_second_window_and_while_the_manager_is_dead(
        window, served):
    stop_the_fleet(window, served)
    window.driver.refresh()
    window.wait(lambda: 'by anna (page)' in stopped_words(window), 'the bar after a reload')
    other = Browser()
    try:
        other.open(served.url)
        other.wait(lambda: stopped_words(other) == stopped_words(window), 'the bar')
        assert other.driver.title == 'STOPPED – Fleet'
    finally:
        other.close()
    served.die()
    window.wait(lambda: 'does not answer' in window.text('#old_state'))
    assert 'by anna (page)' in stopped_words(window)


@pytest.mark.parametrize('width, height', [(390, 844), (1400, 900)])
@pytest.mark.parametrize('theme', ['light', 'dark'])
def test_the_bar_of_a_stop_stays_in_view_in_german_too(window, served, width, height, theme):
    why = 'ld90_3 was stopped by a command that bypassed the fleet manager'
    window.resize(width, height)
    window.script("localStorage.setItem('language', 'de'); localStorage.setItem('theme', "
                  'arguments[0])', theme)
    try:
        window.driver.refresh()
        served.do(lambda: served.page.model.show_stop(
            FleetStop(StopCause.BYPASSED, '', 1700000000.0, why)))
        window.wait(lambda: 'DIE FLOTTE IST ANGEHALTEN seit' in stopped_words(window))
        assert 'ld90_3 wurde durch einen Befehl angehalten' in stopped_words(window)
        window.script('scrollTo(0, document.documentElement.scrollHeight)')
        window.picture(f'stopped_{theme}_{width}')
        box = window.script("return document.getElementById('stopped').getBoundingClientRect()")
        assert 0 <= box['top'] < box['bottom'] < height and box['left'] >= 0
        assert box['right'] <= width
    finally:
        window.script('localStorage.clear()')


def test_a_stop_does_not_wait_for_pages_of_the_same_browser_that_follow_the_fleet(window, served):
    driver = window.driver
    first = driver.current_window_handle
    for _ in range(7):
        driver.switch_to.new_window('tab')
        driver.get(served.url)
    window.click('#stop')
    try:
        asked(window, served, ActKind.STOP)
    finally:
        for handle in driver.window_handles:
            if handle != first:
                driver.switch_to.window(handle)
                driver.close()
        driver.switch_to.window(first)


def test_a_stop_does_not_wait_for_requests_that_the_page_does_not_answer(window, served):
    served.hang()
    for _ in range(10):
        window.script("document.getElementById('load_audit').click()")
    window.click('#stop')
    asked(window, served, ActKind.STOP)
    served.go_on()
    window.problems()  # forgets the errors of the cancelled requests


def test_a_mission_is_sent_by_clicks_on_the_map(window, served):
    for vertex in (3, 7, 6):
        window.click_vertex(vertex)
    window.wait(lambda: len(window.driver.find_elements('css selector', '#chosen li')) == 3)
    window.one('#chosen li:nth-child(2) input[type=number]').send_keys('5')
    window.click('#chosen li:nth-child(3) input[type=checkbox]')
    window.one('#send_priority').clear()
    window.one('#send_priority').send_keys('4')
    options = "return document.querySelector('#send_robot').options.length"
    window.wait(lambda: window.script(options) == 3)
    window.script("document.querySelector('#send_robot').value = 'b'")
    window.picture('mission')
    window.click('#send_button')
    act = asked(window, served, ActKind.SEND)
    assert act.destinations == (3, 7, 6) and act.robot == 'b' and act.priority == 4
    assert act.stays[0] == 0.0 and act.stays[1] > 0.0 and act.stays[2] == -1.0


def test_favourites_are_kept_used_and_removed(window, served):
    window.click_vertex(3)
    window.one('#favourite_name').send_keys('<b>tour</b>')
    window.click('#keep')
    window.wait(lambda: '<b>tour</b>: 3' in window.text('#favourites'))
    window.click('#clear')
    window.click('#favourites [data-act=use]')
    window.click('#send_button')
    asked(window, served, ActKind.SEND, destinations=(3,))
    window.click('#favourites [data-act=remove]')
    window.wait(lambda: window.text('#favourites') == '')


def show_templates(served):
    """Shows a template whose parameters are places, a template without parameters, and a station.
    """
    served.do(lambda: (
        served.page.model.show_templates([ShownTemplate('pallet', ('from', 'to')),
                                          ShownTemplate('tour', ())]),
        served.page.model.show_resources([ShownResource('press', 'STATION', vertices=(6,))])))


def choose(window, id, value):
    window.script('''const select = document.getElementById(arguments[0]);
        select.value = arguments[1]; select.dispatchEvent(new Event('change'));''', id, value)


def test_a_template_is_run_with_parameters_by_name_and_by_a_click_on_the_map(window, served):
    show_templates(served)
    window.wait(lambda: window.one('#send_template').is_displayed(), 'the templates')
    choose(window, 'send_template', 'pallet')
    assert not window.one('#destination').is_displayed()
    window.one('#parameters [name=from]').send_keys('press')
    window.one('#parameters [name=to]').click()
    window.click_vertex(7)
    window.wait(lambda: window.one('#parameters [name=to]').get_attribute('value') == '7')
    window.picture('template')
    window.one('#send_priority').clear()
    window.one('#send_priority').send_keys('2')
    window.click('#send_button')
    asked(window, served, ActKind.RUN, name='pallet', priority=2,
          arguments=(('from', 'press'), ('to', '7')))
    window.wait(lambda: window.one('#parameters [name=to]').get_attribute('value') == '')


def test_clicks_fill_one_parameter_after_the_other_and_a_label_is_sent_as_its_vertex(
        window, served):
    show_templates(served)
    window.wait(lambda: window.one('#send_template').is_displayed(), 'the templates')
    choose(window, 'send_template', 'pallet')
    window.click_vertex(1)
    window.wait(lambda: window.one('#parameters [name=from]').get_attribute('value') == '1 dock')
    window.click_vertex(3)
    window.wait(lambda: window.one('#parameters [name=to]').get_attribute('value') == '3')
    window.click('#send_button')
    asked(window, served, ActKind.RUN, arguments=(('from', '1'), ('to', '3')))
    choose(window, 'send_template', 'tour')
    window.click('#send_button')
    window.wait(lambda: served.fleet.acts[-1][0].name == 'tour')
    assert served.fleet.acts[-1][0].arguments == ()


def test_timetables_are_listed_with_their_next_run_and_paused_and_resumed(window, served):
    soon = time.mktime((2026, 11, 27, 6, 30, 0, 0, 0, -1))
    milk = ShownTimetable('milk', 'pallet', (('to', '39'),), 30, 360, 1080, (0, 1, 2, 3, 4), soon)
    served.do(lambda: served.page.model.show_timetables([milk]))
    window.click('#timetables_box summary')
    window.wait(lambda: 'milk' in window.text('#timetables'))
    for words in ('next Fri 06:30 AM', 'pallet · to = 39', 'every 30 min, 06:00–18:00, Mon–Fri'):
        assert words in window.text('#timetables')
    window.picture('timetables')
    window.click('#timetables [data-act=pause]')
    asked(window, served, ActKind.PAUSE_TIMETABLE, name='milk')
    served.do(lambda: served.page.model.show_timetables([replace(milk, next=None)]))
    window.wait(lambda: 'paused' in window.text('#timetables'))
    window.click('#timetables [data-act=pause]')
    asked(window, served, ActKind.RESUME_TIMETABLE, name='milk')
    window.script('localStorage.clear()')


def act_on_mission(window, act):
    """Chooses an act in the menu of mission 7."""
    window.click(f'{MISSION} [data-act=menu]')
    window.click(f'#menu [data-act={act}]')


@pytest.mark.parametrize('kind', [ActKind.CANCEL, ActKind.PAUSE, ActKind.RELEASE])
def test_an_open_mission_is_changed_by_its_buttons(window, served, kind):
    act_on_mission(window, kind.value)
    asked(window, served, kind, mission=7)


def test_a_paused_mission_goes_on(window, served):
    served.do(lambda: served.page.update_status(status(7, 'PAUSED')))
    window.wait(lambda: 'paused' in window.text('#open'))
    act_on_mission(window, 'continue')
    asked(window, served, ActKind.CONTINUE, mission=7)


def test_priority_and_destinations_of_a_mission_are_changed(window, served):
    act_on_mission(window, 'change')
    window.one('#open form input[type=number]').clear()
    window.one('#open form input[type=number]').send_keys('9')
    way = window.one('#open form input:not([type])')
    way.clear()
    way.send_keys('4 8')
    window.click('#open form button')
    asked(window, served, ActKind.MODIFY, mission=7, priority=9, destinations=(4, 8))


def test_what_is_typed_outlives_news_of_the_mission(window, served):
    act_on_mission(window, 'change')
    way = window.one('#open form input:not([type])')
    way.clear()
    way.send_keys('4 ')
    served.do(lambda: served.page.update_status(status(7, 'ACTIVE', reached=1, reason='news')))
    window.wait(lambda: 'news' in window.text('#open'))
    window.driver.switch_to.active_element.send_keys('8')
    window.click('#open form button')
    asked(window, served, ActKind.MODIFY, mission=7, destinations=(4, 8))


def test_edges_are_closed_and_opened(window, served):
    window.click('#tab_button_edges')
    window.one('#edge').send_keys('3')
    window.click('#close_edge')
    asked(window, served, ActKind.CLOSE, edges=(3,))
    served.do(lambda: served.page.model.close_edges([3]))
    window.click('#closed [data-act=open]')
    asked(window, served, ActKind.OPEN, edges=(3,))


def test_an_area_has_a_name_and_is_closed_and_opened_as_one(window, served):
    cut = split_edges(served.page.model.graph, 1.6)
    sections = {edge: sorted(cut.whole_edges([edge])) for edge in (3, 4)}
    served.do(lambda: (setattr(served.page.model, 'graph', cut), served.page.model.site_changed()))
    window.click('#tab_button_edges')
    window.one('#edge').send_keys('3 4')
    window.one('#area_name').send_keys('<b>hall</b>')
    window.click('#keep_area')
    window.wait(lambda: '<b>hall</b> · Edge 3, 4 · open' in window.text('#areas'))
    window.click('#areas [data-act=close]')
    asked(window, served, ActKind.CLOSE, edges=(3, 4))
    served.do(lambda: served.page.model.close_edges(sections[3]))
    window.wait(lambda: '1 of 2 edges closed' in window.text('#areas'))
    served.do(lambda: served.page.model.close_edges(sections[3] + sections[4]))
    window.wait(lambda: '· closed' in window.text('#areas'))
    window.click('#areas [data-act=open]')
    asked(window, served, ActKind.OPEN, edges=(3, 4))
    window.click('#areas [data-act=remove_area]')
    window.wait(lambda: window.text('#areas') == '')


def open_layers(window):
    if not window.one('#layers').is_displayed():
        window.click('#layers_button')


def layer(window, name):
    open_layers(window)
    window.click(f'#layers [data-layer={name}]')


def sources(served):
    return served.do(lambda: set(served.web._sources))


def test_an_area_is_outlined_with_its_name_which_closes_and_opens_it(window, served):
    served.do(lambda: (served.page.records.keep_named(NamedKind.AREA, 'bay', {'edges': [3, 4]}),
                       served.page.model.show_named('areas', {'bay': {'edges': [3, 4]}})))
    window.wait(lambda: window.text('#map_areas') == 'bay')
    window.picture('area')
    for kind in (ActKind.CLOSE, ActKind.OPEN):
        box = window.script("return document.querySelector('#map_areas rect')"
                            '.getBoundingClientRect()')
        window.click_at(box['x'] + box['width'] / 2, box['y'] + box['height'] / 2)
        window.click(f'#menu [data-act={kind.value}]')
        asked(window, served, kind, edges=(3, 4))
    layer(window, 'areas')
    window.wait(lambda: window.text('#map_areas') == '')
    window.script('localStorage.clear()')


def test_a_named_area_is_closed_by_keyboard_alone(window, served):
    from selenium.webdriver.common.keys import Keys
    served.do(lambda: served.page.model.show_named('areas', {'bay': {'edges': [3, 4]}}))
    window.wait(lambda: window.text('#map_areas') == 'bay')
    window.script("document.querySelector('#map_areas .area').focus()")
    window.driver.switch_to.active_element.send_keys(Keys.ENTER)
    window.wait(lambda: window.script('return document.activeElement.dataset.act') == 'close')
    window.driver.switch_to.active_element.send_keys(Keys.ENTER)
    asked(window, served, ActKind.CLOSE, edges=(3, 4))


def test_layers_are_kept_in_the_browser_and_their_entries_come_only_while_they_are_shown(
        window, served):
    def show():
        served.page.model.show_allocations({'a': ShownAllocation(((1, 0.5),), 0)})
        served.page.model.show_laser('a', [0, 0, 100, 100, 300, 50])
    served.do(show)
    released = '.released[data-robot=a]'
    assert window.one(released) and sources(served) == set()
    layer(window, 'plan')
    window.wait(lambda: not window.driver.find_elements('css selector', released))
    layer(window, 'allocation')
    window.one('.allocations [data-robot=a]')
    assert sources(served) == {'allocation'}
    layer(window, 'laser')
    window.wait(lambda: 'Choose a robot' in window.text('#layer_hint'))
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    laser = "return document.querySelector('.laser').getAttribute('d').split('M').length"
    window.wait(lambda: window.script(laser) == 4)
    assert sources(served) == {'allocation', 'laser:a'}
    window.picture('layers')
    window.open(served.url)
    window.one('.allocations [data-robot=a]')
    assert not window.driver.find_elements('css selector', released)
    layer(window, 'allocation')
    window.wait(lambda: sources(served) == set())
    window.script('localStorage.clear()')


def test_on_a_phone_the_menu_of_layers_takes_the_place_of_the_panel_until_a_tab_is_chosen(
        window, served):
    window.resize(390, 844)
    window.click('#layers_button')
    box, around = window.one('#layers').rect, window.one('#map').rect
    assert box['y'] >= around['y'] + around['height'] - 1
    window.click('[data-layer=heat]')
    window.click('#tab_button_robots')
    assert window.one('#robots').is_displayed() and not window.one('#layers').is_displayed()
    window.script('localStorage.clear()')


def test_the_heat_and_the_fences_are_asked_for_while_their_layers_are_shown(window, served):
    served.do(lambda: (
        served.page.records.add(time.time(), {}, {3: 60.0, 4: 20.0}),
        setattr(served.page.site, 'fences', ((1.0, 1.0, 2.0, 1.0, 2.0, 2.0, 1.0, 2.0),
                                             (0.0, 4.0, 6.0, 4.0)))))
    assert not any('/api/fences' in url or '/api/history' in url for url in window.addresses())
    for name, path in (('heat', '/api/history?hours=24'), ('fences', '/api/fences')):
        before = window.script(PIXELS)
        layer(window, name)
        window.wait(lambda: window.script(PIXELS) != before, name)  # noqa: B023
        assert any(path in url for url in window.addresses())
    window.picture('heat_and_fences')
    window.script('localStorage.clear()')


PIXELS = "return document.getElementById('site').toDataURL()"


def test_the_page_knows_the_edges_and_places_of_the_users_graph_not_their_sections(window, served):
    cut = split_edges(served.page.model.graph, 1.6)
    sections = sorted(cut.whole_edges([3]))
    between = cut.end_vertex(sections[0]).id
    served.do(lambda: (setattr(served.page.model, 'graph', cut), served.page.model.site_changed(),
                       served.page.model.close_edges(sections)))
    window.click('#tab_button_edges')
    window.wait(lambda: len(window.driver.find_elements('css selector', '#closed li')) == 1)
    assert window.text('#closed li').startswith('Edge 3')
    window.click('#closed [data-act=open]')
    asked(window, served, ActKind.OPEN, edges=(3,))
    window.click('#tab_button_missions')
    window.click_vertex(between)  # a click here only chooses the edge
    window.wait(lambda: window.one('#edge').get_attribute('value') == '3')
    assert window.driver.find_elements('css selector', '#chosen li') == []


@pytest.mark.parametrize('kind', [ActKind.OUT, ActKind.IN, ActKind.ABSENT])
def test_a_robot_is_taken_out_put_back_and_declared_absent(window, served, kind):
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    window.click(f'#robots li[data-key=a] [data-act={kind.value}]')
    if kind is ActKind.ABSENT:
        window.driver.switch_to.alert.accept()
    asked(window, served, kind, robot='a')


def test_a_dead_fleet_manager_is_told_with_the_age_and_the_stop_still_works(window, served):
    served.die()
    window.wait(lambda: 'does not answer' in window.text('#old_state'))
    assert window.one('.robot[data-name=a]')
    window.picture('dead')
    window.click('#stop')
    asked(window, served, ActKind.STOP)


def test_history_replay_and_audit_list_are_shown(window, served):
    window.click('#stop')
    window.click('#tab_button_history')
    window.wait(lambda: window.text('#hours_table').strip())
    window.wait(lambda: window.script('return !document.querySelector("#hours_chart").hidden'))
    window.picture('history')
    window.click('#tab_button_audit')
    window.wait(lambda: 'Stop all' in window.text('#audit'))
    window.click('#tab_button_replay')
    window.wait(lambda: served.do(lambda: served.page.replay.span))
    window.click('#tab_button_replay')
    window.wait(lambda: window.one('#moment').is_enabled())
    window.script('''const slider = document.querySelector('#moment');
        slider.value = slider.max; slider.dispatchEvent(new Event('input'));''')
    window.wait(lambda: 'wheel blocked' in window.text('#past_robots'))
    window.picture('replay')
    window.click('#live')
    window.wait(lambda: not window.one('#past').is_displayed())


def test_words_of_robots_and_missions_never_become_html(window, served):
    evil = '<img src=x onerror=document.title="taken">'
    served.do(lambda: served.page.model.update_robots(
        [robot(evil, waits_for=evil, outage='FAILED', state='FAILED')], time.time()))
    served.do(lambda: served.page.update_status(status(7, 'FAILED', reason=evil, robot=evil)))
    window.wait(lambda: evil in window.text('#alarms') and evil in window.text('#ended'))
    assert window.driver.title == 'Fleet'
    assert window.driver.find_elements('css selector', 'img') == []


def test_german_and_dark_are_chosen_and_remembered(window, served):
    window.script('''const language = document.querySelector('#language');
        language.value = 'de'; language.dispatchEvent(new Event('change'));''')
    window.wait(lambda: window.text('#stop') == 'ALLE ANHALTEN')
    theme = window.script('return document.documentElement.dataset.theme')
    window.click('#theme')
    window.open(served.url)
    window.wait(lambda: 'fährt zu 2' in window.one('.robot[data-name=a]').get_attribute(
        'aria-label'))
    assert window.script('return document.documentElement.dataset.theme') != theme
    window.wait(lambda: 'seine Fahrt ist gescheitert („wheel blocked“)' in window.text('#alarms'))
    for id, reason, words in ((8, 'it waits for a to be free', 'er wartet, bis a frei ist'),
                              (9, 'a: it does not report', 'a: er meldet sich nicht')):
        served.do(lambda: served.page.update_status(status(id, 'FAILED', reason=reason)))  # noqa: B023
        window.wait(lambda: words in window.text('#ended'), words)  # noqa: B023
    for reason in ('the disk: a.b*(c', 'x'):
        served.do(lambda: served.page.update_status(status(7, 'PAUSED', reason=reason)))  # noqa: B023
    window.wait(lambda: window.text('#open .soft') == 'x')
    window.picture('german_dark')
    window.script('localStorage.clear()')


@pytest.mark.parametrize('width, height, language', [(360, 740, 'de'), (2560, 1440, 'en')])
def test_no_text_of_a_fleet_in_trouble_is_cut_off_or_lies_on_another_from_phone_to_wall(
        browser, tmp_path, width, height, language):
    served = ServedPage(tmp_path, fill=partial(show, count=8, in_trouble=True, is_stopped=True))
    found = {}
    try:
        browser.resize(width, height)
        browser.open(served.url)
        browser.one('.robot')
        browser.script("document.getElementById('language').value = arguments[0];", language)
        for view in ('template', 'robots', 'edges', 'history', 'replay', 'audit', 'alarms'):
            open_view(browser, view, frames=6)
            if view == 'history':
                browser.wait(lambda: browser.text('#robots_table').strip())
            if browser.script('return document.documentElement.scrollWidth > innerWidth'):
                found[view] = ['the page is wider than the window']
            found.setdefault(view, []).extend(layout_faults(browser))
            assert browser.one('#stop').is_displayed()
    finally:
        browser.script('localStorage.clear()')
        served.close()
    assert {view: faults for view, faults in found.items() if faults} == {}


@pytest.mark.parametrize('style, words', [
    ('#link { position: absolute; left: 4px; top: 12px; }', 'overlap: "Fleet"'),
    ('#stop { width: 3rem; white-space: nowrap; }', 'cut: "STOP ALL" in button #stop'),
    ('#send_robot { width: 2.5rem !important; }', 'cut: "any" in select #send_robot'),
    ('#resume { position: fixed; left: -2rem; }', 'outside: "Go on"')])
def test_the_judge_of_texts_finds_a_planted_fault(window, served, style, words):
    assert layout_faults(window) == []
    window.script('''const sheet = new CSSStyleSheet();
        sheet.replaceSync(arguments[0]);
        document.adoptedStyleSheets = [sheet];''', style)
    assert any(fault.startswith(words) for fault in layout_faults(window)), layout_faults(window)


def test_a_name_keeps_clear_of_the_ring_of_a_station_and_of_the_bar_of_a_stop(window, served):
    served.do(lambda: served.page.model.show_resources(
        [ShownResource('press', 'STATION', vertices=(12,)),
         ShownResource('gate', 'DOOR', edges=(9,), device='CLOSED')]))
    stop_the_fleet(window, served)
    window.wait(lambda: len(window.driver.find_elements('css selector', '.resource text')) == 2)
    covered = window.script('''
        const marks = [...document.querySelectorAll('.resource circle, #bars')].map(one =>
            one.getBoundingClientRect());
        return [...document.querySelectorAll('#moving text')].filter(text => {
            const box = text.getBoundingClientRect();
            return marks.some(mark => box.left + 2 < mark.right && mark.left + 2 < box.right &&
                              box.top + 5 < mark.bottom && mark.top + 5 < box.bottom);
        }).map(text => text.textContent);''')
    assert covered == []


def test_a_mission_is_sent_by_keyboard_alone(window, served):
    from selenium.webdriver.common.action_chains import ActionChains
    from selenium.webdriver.common.keys import Keys

    def focus_on(wanted):
        for _ in range(60):
            if window.script('return document.activeElement.id') == wanted:
                return window.driver.switch_to.active_element
            ActionChains(window.driver).send_keys(Keys.TAB).perform()
        raise AssertionError(f'the focus never came to {wanted}')
    focus_on('destination').send_keys('7', Keys.ENTER)
    focus_on('destination').send_keys('3', Keys.ENTER)
    focus_on('send_button').send_keys(Keys.ENTER)
    asked(window, served, ActKind.SEND, destinations=(7, 3))
    focus_on('tab_button_missions').send_keys(Keys.ARROW_RIGHT)
    assert window.script('return document.activeElement.id') == 'tab_button_robots'


def test_two_windows_see_the_same(window, served):
    first = window.driver.current_window_handle
    window.driver.switch_to.new_window('window')
    try:
        window.open(served.url)
        window.one('.robot[data-name=a]')
        served.do(lambda: served.page.model.update_robots(
            [robot('a', waits_for='b')], time.time()))
        window.wait(lambda: 'waits for: b' in window.text('#robots'))
    finally:
        window.driver.close()
        window.driver.switch_to.window(first)
    window.wait(lambda: 'waits for: b' in window.text('#robots'))


def test_who_only_sees_logs_in_and_finds_nothing_to_press(browser, tmp_path):
    shown = ServedPage(tmp_path, secured=True)
    try:
        browser.resize(1400, 900)
        browser.open(shown.url)
        browser.one('#token').send_keys('wrong')
        browser.click('#login button')
        browser.wait(lambda: 'is not valid' in browser.text('#login_said'))
        browser.one('#token').send_keys(TOKENS['see'])
        browser.click('#login button')
        browser.one('.robot[data-name=a]')
        assert not browser.one('#stop').is_enabled()
        assert not browser.one('#send_button').is_displayed()
        assert TOKENS['see'] not in browser.driver.current_url
        assert browser.script('return document.cookie') == ''
        browser.picture('see')
        browser.click('#logout')
        browser.wait(lambda: browser.one('#login').is_displayed())
    finally:
        shown.close()


def test_without_a_chart_library_tables_are_shown(browser, tmp_path):
    shown = ServedPage(tmp_path, chart=str(tmp_path / 'none.js'))
    try:
        browser.resize(1400, 900)
        browser.open(shown.url)
        browser.one('.robot[data-name=a]')
        browser.click('#tab_button_history')
        browser.wait(lambda: browser.text('#robots_table').strip())
        assert not browser.one('#hours_chart').is_displayed()
    finally:
        shown.close()

