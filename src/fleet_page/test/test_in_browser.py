"""The page in a real Chromium: each act from click to fleet, languages, sizes, keyboard."""
from __future__ import annotations

import time

import pytest

pytest.importorskip('aiohttp')

from browser import Browser, ServedPage, needs_browser  # noqa: E402
from page_builders import TOKENS, robot, status  # noqa: E402

from fleet_core.supervision.fleet_stop import (  # noqa: E402
    NOT_STOPPED,
    FleetStop,
    StopCause,
)
from fleet_page.core.acts import ActKind  # noqa: E402
from fleet_page.core.fleet import ShownPose  # noqa: E402
from trajectory_graph import split_edges  # noqa: E402

pytestmark = needs_browser


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
    browser.wait(lambda: 'wheel blocked' in browser.text('#alarms'))  # this text moves the map
    browser.addresses()
    browser.problems()
    yield browser
    outside = [url for url in browser.addresses()
               if not url.startswith((served.url, 'data:', 'chrome'))]
    assert outside == [] and browser.problems() == []


def asked(window, served, kind, **values):
    """The act that arrived at the fleet."""
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
    assert window.one('#ended li')
    window.picture('live')


def test_a_robot_that_moves_is_drawn_where_it_is(window, served):
    before = window.one('.robot[data-name=a]').get_attribute('transform')
    served.do(lambda: served.page.model.take_places({'a': ShownPose(2.5, 0.0, 0.0)}))
    window.wait(lambda: window.one('.robot[data-name=a]').get_attribute('transform') != before)


def test_the_stop_button_stops(window, served):
    window.click('#stop')
    asked(window, served, ActKind.STOP)
    window.wait(lambda: 'stop was asked' in window.text('#said'))
    window.click('#resume')
    asked(window, served, ActKind.RESUME)


BAR = 'THE FLEET IS STOPPED since '


def stopped_words(window):
    """The words of the red bar; empty: it is not shown."""
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
    window.wait(lambda: 'does not answer' in window.text('#link'))
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
    window.problems()  # the requests that were given up


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


@pytest.mark.parametrize('kind', [ActKind.CANCEL, ActKind.PAUSE, ActKind.RELEASE])
def test_an_open_mission_is_changed_by_its_buttons(window, served, kind):
    window.click(f'#open li[data-key^="7:"] [data-act={kind.value}]')
    asked(window, served, kind, mission=7)


def test_a_paused_mission_goes_on(window, served):
    served.do(lambda: served.page.take_status(status(7, 'PAUSED')))
    window.click('#open li[data-key^="7:"] [data-act=continue]')
    asked(window, served, ActKind.CONTINUE, mission=7)


def test_priority_and_destinations_of_a_mission_are_changed(window, served):
    window.click('#open li[data-key^="7:"] [data-act=change]')
    window.one('#open form input[type=number]').clear()
    window.one('#open form input[type=number]').send_keys('9')
    way = window.one('#open form input:not([type])')
    way.clear()
    way.send_keys('4 8')
    window.click('#open form button')
    asked(window, served, ActKind.MODIFY, mission=7, priority=9, destinations=(4, 8))


def test_what_is_typed_outlives_news_of_the_mission(window, served):
    window.click('#open li[data-key^="7:"] [data-act=change]')
    way = window.one('#open form input:not([type])')
    way.clear()
    way.send_keys('4 ')
    served.do(lambda: served.page.take_status(status(7, 'ACTIVE', reached=1, reason='news')))
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
    window.click_vertex(between)  # nothing but the edge is there
    window.wait(lambda: window.one('#edge').get_attribute('value') == '3')
    assert window.driver.find_elements('css selector', '#chosen li') == []


@pytest.mark.parametrize('kind', [ActKind.OUT, ActKind.IN, ActKind.ABSENT])
def test_a_robot_is_taken_out_put_back_and_declared_absent(window, served, kind):
    window.click('#tab_button_robots')
    window.click(f'#robots li[data-key=a] [data-act={kind.value}]')
    if kind is ActKind.ABSENT:
        window.driver.switch_to.alert.accept()
    asked(window, served, kind, robot='a')


def test_a_dead_fleet_manager_is_told_with_the_age_and_the_stop_still_works(window, served):
    served.die()
    window.wait(lambda: 'does not answer' in window.text('#link'))
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
    served.do(lambda: served.page.model.take_robots(
        [robot(evil, waits_for=evil, outage='FAILED', state='FAILED')], time.time()))
    served.do(lambda: served.page.take_status(status(7, 'FAILED', reason=evil, robot=evil)))
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
        served.do(lambda: served.page.take_status(status(id, 'FAILED', reason=reason)))  # noqa: B023
        window.wait(lambda: words in window.text('#ended'), words)  # noqa: B023
    for reason in ('the disk: a.b*(c', 'x'):
        served.do(lambda: served.page.take_status(status(7, 'PAUSED', reason=reason)))  # noqa: B023
    window.wait(lambda: window.text('#open li p') == 'x')
    window.picture('german_dark')
    window.script('localStorage.clear()')


@pytest.mark.parametrize('width, height, language', [(360, 740, 'de'), (2560, 1440, 'en')])
def test_nothing_is_cut_off_from_phone_to_wall(window, served, width, height, language):
    window.script('''const language = document.querySelector('#language');
        language.value = arguments[0]; language.dispatchEvent(new Event('change'));''', language)
    window.resize(width, height)
    window.wait(lambda: window.script('return innerWidth') == width)
    for tab in ('missions', 'robots', 'edges', 'history', 'replay', 'audit'):
        window.click(f'#tab_button_{tab}')
        if tab == 'history':
            window.wait(lambda: window.text('#robots_table').strip())
        wide = window.script('return document.documentElement.scrollWidth')
        assert wide <= window.script('return document.documentElement.clientWidth'), tab
        assert window.one('#stop').is_displayed()
    window.click('#tab_button_missions')
    window.picture(f'{width}')
    window.script('localStorage.clear()')


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
        served.do(lambda: served.page.model.take_robots(
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

