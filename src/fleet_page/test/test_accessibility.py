"""axe-core finds no problem on any tab of a page with troubles: light, dark, on phone and desktop.

The test runs only with `scripts/test.sh --long`, which installs axe-core in build/axe.
"""
from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

pytest.importorskip('aiohttp')

from browser import Browser, ServedPage, needs_browser  # noqa: E402
from page_builders import status  # noqa: E402
from pictures import show_work  # noqa: E402

from fleet_core.supervision.fleet_stop import FleetStop, StopCause  # noqa: E402

AXE = next(Path(__file__).resolve().parents[3].glob('build/axe/lib/*/site-packages/*/axe.min.js'),
           None)
pytestmark = [needs_browser, pytest.mark.skipif(
    AXE is None or os.environ.get('LD90_LONG_TESTS') != '1',
    reason='needs scripts/test.sh --long, which fetches axe-core')]
RUN = '''const done = arguments[0];
axe.run().then(found => done([found.passes.length, found.violations.map(
  one => [one.id, one.nodes.map(node => node.html)])]));'''
TAB_OF = {'template': 'missions', 'layers': 'robots'}
JUDGED = 10  # least number of rules that axe-core must apply, so that the check counts


@pytest.fixture(scope='module')
def window(tmp_path_factory):
    shown, window = ServedPage(tmp_path_factory.mktemp('page')), Browser()
    window.open(shown.url)
    window.one('.robot[data-name=a]')
    window.click('#stop')
    shown.do(lambda: (
        shown.page.model.show_stop(FleetStop(StopCause.PERSON, 'anna (page)', time.time())),
        shown.page.update_status(status(7, 'NEEDS_PERSON', serial=42, reason='no pallet', asks=5)),
        shown.page.records.keep_charges(time.time() - 600.0, {'a': 0.8}),
        show_work(shown.page, time.time()),
        shown.page.model.show_named('areas', {'bay': {'edges': [3, 4]}})))
    window.click('#tab_button_robots')
    window.click('#robots li[data-key=a] [data-act=choose]')
    window.one('#robots .curve')
    window.script("localStorage.setItem('alarms', 'open')")
    window.script("localStorage.setItem('layers', 'areas laser heat')")
    window.driver.set_script_timeout(30)
    window.driver.execute_cdp_cmd('Page.setBypassCSP', {'enabled': True})
    window.script(AXE.read_text())
    yield window
    window.close()
    shown.close()


@pytest.mark.parametrize('width', [390, 1400])
@pytest.mark.parametrize('theme', ['light', 'dark'])
@pytest.mark.parametrize('view', ['missions', 'template', 'layers', 'robots', 'edges', 'history',
                                  'replay', 'audit'])
def test_axe_finds_nothing(window, view, theme, width):
    window.resize(width, 900)
    window.click(f'#tab_button_{TAB_OF.get(view, view)}')
    window.script('''const select = document.getElementById('send_template');
        select.value = arguments[0] === 'template' ? 'pallet' : '';
        select.dispatchEvent(new Event('change'));
        document.getElementById('timetables_box').open = true;
        if (document.getElementById('layers').hidden !== (arguments[0] !== 'layers'))
            document.getElementById('layers_button').click();''', view)
    window.script(f'document.documentElement.dataset.theme = "{theme}"')
    judged, found = window.driver.execute_async_script(RUN)
    assert judged >= JUDGED and found == []
