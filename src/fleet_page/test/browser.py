"""A real Chromium without a display, and a page that a thread serves to this browser, without ROS.
"""
from __future__ import annotations

import asyncio
import os
import shutil
import threading
import time
from pathlib import Path
from typing import Any, Callable, Optional

import pytest
from page_builders import ServedSite, show_fleet

from fleet_page.core.page import Page
from fleet_page.door.files import CHART

try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
except ImportError:
    webdriver = None
DRIVER = shutil.which('chromedriver')
BROWSER = shutil.which('chromium')
MISSING = '' if webdriver and DRIVER and BROWSER else (
    'this distribution has no chromium, chromium-driver or python3-selenium')
needs_browser = pytest.mark.skipif(bool(MISSING), reason=MISSING or 'there is a browser')
PICTURES = Path(os.environ.get('SYSTEM_TEST_ARTEFACTS', ''))
PATIENCE = 8.0  # s


class ServedPage:
    """A page on a free port, served by its own thread; `do` runs a function in this thread."""

    def __init__(self, folder: Path, secured: bool = False, chart: str = CHART,
                 fill: Callable[[Page], None] = show_fleet) -> None:
        self._site = ServedSite(folder, secured, chart=chart)
        self.fleet, self.web = self._site.fleet, self._site.web
        self.page: Page = self._site.page
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        self._alive = True
        asyncio.run_coroutine_threadsafe(self._site.open(), self._loop).result(PATIENCE)
        self.url = f'http://127.0.0.1:{self._site.port}/'
        self.do(lambda: fill(self.page))
        self._ticking = asyncio.run_coroutine_threadsafe(self._tick(), self._loop)

    async def _tick(self) -> None:
        """Publishes the state of the fleet manager while it runs."""
        while True:
            if self._alive:
                self.page.model.update_robots(self.page.model.robots.values(), time.time())
            self.page.tick(time.time())
            await asyncio.sleep(0.2)

    def do(self, work: Callable[[], Any]) -> Any:
        """Runs a function in the page's thread; returns its result."""
        async def run() -> Any:
            return work()
        return asyncio.run_coroutine_threadsafe(run(), self._loop).result(PATIENCE)

    def die(self) -> None:
        """Makes the fleet manager publish nothing any more."""
        self._alive = False

    def hang(self) -> None:
        """Makes the page's process accept no requests any more."""
        asyncio.run_coroutine_threadsafe(self._site.hang(), self._loop).result(PATIENCE)

    def go_on(self) -> None:
        """Makes the page's process work again."""
        asyncio.run_coroutine_threadsafe(self._site.go_on(), self._loop).result(PATIENCE)

    def close(self) -> None:
        asyncio.run_coroutine_threadsafe(self._end(), self._loop).result(PATIENCE)
        self._loop.call_soon_threadsafe(self._loop.stop)

    async def _end(self) -> None:
        self._ticking.cancel()
        await self._site.close()
        ending = asyncio.all_tasks() - {asyncio.current_task()}
        for task in ending:
            task.cancel()
        await asyncio.gather(*ending, return_exceptions=True)


class Browser:
    """One window."""

    def __init__(self, width: int = 1400, height: int = 900, language: str = 'en',
                 profile: Optional[Path] = None) -> None:
        options = webdriver.ChromeOptions()
        options.binary_location = BROWSER
        for word in ('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
                     '--disable-background-networking', '--no-first-run', f'--lang={language}',
                     f'--window-size={width},{height}'):
            options.add_argument(word)
        options.add_experimental_option('prefs', {'intl.accept_languages': language})
        options.set_capability('goog:loggingPrefs', {'browser': 'ALL', 'performance': 'ALL'})
        self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)

    def resize(self, width: int, height: int) -> None:
        """Sets the size of the visible area, for example to the size of a phone."""
        self.driver.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', {
            'width': width, 'height': height, 'deviceScaleFactor': 1, 'mobile': False})

    def open(self, url: str) -> None:
        self.driver.get(url)

    def script(self, text: str, *values: Any) -> Any:
        return self.driver.execute_script(text, *values)

    def wait(self, condition: Callable[[], Any], what: str = 'it') -> Any:
        """Waits until the condition is true. An error of an element that comes or goes counts as
        false.
        """
        from selenium.common.exceptions import WebDriverException
        deadline = time.monotonic() + PATIENCE
        while True:
            try:
                found = condition()
                if found:
                    return found
            except WebDriverException as error:
                found = error
            assert time.monotonic() < deadline, f'{what} did not appear: {found}'
            time.sleep(0.03)

    def one(self, selector: str) -> Any:
        return self.wait(lambda: self.driver.find_elements('css selector', selector),
                         selector)[0]

    def click(self, selector: str) -> None:
        def clicked() -> bool:
            self.driver.find_element('css selector', selector).click()
            return True
        self.wait(clicked, selector)

    def click_vertex(self, vertex: int) -> None:
        """Clicks on the map at the drawn vertex, after the map has come to rest.

        The map moves when the window, the panel or the site changes. Messages do not move it.
        """
        x, y = self.wait(lambda: self.driver.execute_async_script('''
            const [vertex, done] = arguments;
            const frame = () => new Promise(requestAnimationFrame);
            import('/page/map.js').then(async map => {
                const before = map.screenPlace(vertex);
                for (let k = 0; k < 3; k++) await frame();
                const place = map.screenPlace(vertex);
                const rests = before && place && before.every((value, k) => value === place[k]);
                done(rests ? place : null);
            });''', vertex), f'vertex {vertex} on the map')
        self.click_at(x, y)

    def click_words(self, selector: str) -> None:
        """Clicks in the middle of an element with words on the map."""
        box = self.wait(lambda: self.script('''
            const box = document.querySelector(arguments[0]).getBoundingClientRect();
            return [box.left + box.width / 2, box.top + box.height / 2];''', selector), selector)
        self.click_at(*box)

    def click_at(self, x: float, y: float) -> None:
        for kind, buttons in (('mousePressed', 1), ('mouseReleased', 0)):
            self.driver.execute_cdp_cmd('Input.dispatchMouseEvent', {
                'type': kind, 'x': x, 'y': y, 'button': 'left', 'buttons': buttons,
                'clickCount': 1})

    def text(self, selector: str) -> str:
        return self.script('return document.querySelector(arguments[0]).textContent', selector)

    def picture(self, name: str) -> None:
        """Saves a picture of the window in the folder of the test's pictures."""
        if Path('') != PICTURES:
            self.driver.save_screenshot(str(PICTURES / f'fleet_page_{name}.png'))

    def addresses(self) -> set:
        """The addresses of all requests that the window has made since the last call."""
        import json
        found = set()
        for entry in self.driver.get_log('performance'):
            message = json.loads(entry['message'])['message']
            if message['method'] == 'Network.requestWillBeSent':
                found.add(message['params']['request']['url'])
        return found

    def problems(self) -> list:
        """Returns the errors, and the contents that were refused, from the browser's console."""
        return [entry['message'] for entry in self.driver.get_log('browser')
                if entry['level'] == 'SEVERE']

    def close(self) -> None:
        self.driver.quit()
