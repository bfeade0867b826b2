"""A real RViz on a screen of its own: finds places of the map in it, clicks, takes pictures.

The screen is an Xvfb of 1280 x 900; xdotool moves the mouse. `missing_programs` lists the programs
that are not installed.

A loaded computer draws late. So each step waits for something visible: a click on a handle waits
until the status bar describes the handle, and a click on a menu entry waits until the entry is
highlighted.
"""
from __future__ import annotations

import math
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import unittest
from typing import Callable, Dict, List, Optional, Sequence, Tuple

import numpy as np
from PIL import Image

from system_support import wait_until

PROGRAMS = ('Xvfb', 'xdotool', 'roslaunch')
RVIZ = ('/usr/bin/rviz', '/opt/ros/noetic/bin/rviz')
WIDTH, HEIGHT = 1280, 900
TOOLBAR_Y = 42
TOOLBAR = (0, 24, 1000, 60)
STATUS_BAR = (0, 872, 1100, 900)
MENU_INSET = 24  # px from a menu's left edge to a point between the mouse pointer and the words
GEOMETRY = re.compile(r'WINDOW=(\d+)\nX=(-?\d+)\nY=(-?\d+)\nWIDTH=(\d+)\nHEIGHT=(\d+)')
REST = 0.5  # s; a picture that has not changed for this time is complete
PATIENCE = 30.0  # s within which RViz must draw new data, on a loaded computer
Colour = Tuple[int, int, int]
Box = Tuple[int, int, int, int]  # left, top, right, bottom; pixels
MENU_COLOUR: Colour = (255, 255, 255)


def missing_programs() -> List[str]:
    """Returns the programs that these tests need and that are not installed."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    return missing if shutil.which('rviz') or any(map(os.path.exists, RVIZ)) else [*missing, 'rviz']


class Screen:
    """An X server without a monitor, with one mouse and one keyboard."""

    def __init__(self) -> None:
        read_end, write_end = os.pipe()
        self._folder = tempfile.TemporaryDirectory()
        self._server = subprocess.Popen(
            ['Xvfb', '-displayfd', str(write_end), '-screen', '0', f'{WIDTH}x{HEIGHT}x24',
             '-fbdir', self._folder.name, '+extension', 'GLX', '-nolisten', 'tcp'],
            pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as answer:
            number = answer.readline().strip()
        if not number:
            raise RuntimeError('Xvfb did not start')
        self.environment = dict(os.environ, DISPLAY=f':{number}', LIBGL_ALWAYS_SOFTWARE='1')

    def close(self) -> None:
        self._server.terminate()
        self._server.wait(10)
        self._folder.cleanup()

    def mouse(self, *command: object) -> None:
        subprocess.run(['xdotool', *map(str, command)], env=self.environment, check=True,
                       timeout=60, stdout=subprocess.DEVNULL)

    def windows(self) -> Dict[str, Box]:
        """Returns the rectangles of the windows on the screen, by id. An open menu is a window.
        """
        found = subprocess.run(
            ['xdotool', 'search', '--onlyvisible', '--maxdepth', '1', '--name', '',
             'getwindowgeometry', '--shell', '%@'], env=self.environment, check=False, timeout=60,
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True).stdout
        return {id: (int(x), int(y), int(x) + int(width), int(y) + int(height))
                for id, x, y, width, height in GEOMETRY.findall(found)}

    def picture(self) -> Image.Image:
        """Returns the picture of the screen, which Xvfb keeps in a file in the format of xwd."""
        path = os.path.join(self._folder.name, 'Xvfb_screen0')
        header = np.fromfile(path, '>u4', 25)  # big-endian on every computer
        header_size, line_size, colours = int(header[0]), int(header[12]), int(header[19])
        pixels = np.fromfile(path, np.uint8, HEIGHT * line_size,
                             offset=header_size + 12 * colours)
        bgrx = pixels.reshape(HEIGHT, line_size // 4, 4)
        return Image.fromarray(np.ascontiguousarray(bgrx[:, :WIDTH, 2::-1]))


class RvizWindow:
    """The window of an RViz that launch/rviz.launch starts. It fills the screen."""

    def __init__(self, screen: Screen, artefacts: str, scale: float, *launch: str) -> None:
        """scale -- scale of the configuration's view, in pixels per metre"""
        self._screen, self._artefacts, self._scale = screen, artefacts, scale
        self._origin: Optional[Tuple[float, float]] = None  # pixel of the map's origin
        self._nothing_here = (0, 0)
        self._process = subprocess.Popen(
            ['roslaunch', '--wait', *(launch or ('omron_ld90', 'rviz.launch'))],
            env=screen.environment, start_new_session=True)
        wait_until(self._is_painted, 60.0, 'the window of RViz')

    def close(self) -> None:
        os.killpg(self._process.pid, signal.SIGINT)
        try:
            self._process.wait(15)
        except subprocess.TimeoutExpired:
            os.killpg(self._process.pid, signal.SIGKILL)
            self._process.wait(5)

    def _is_painted(self) -> bool:
        if self._process.poll() is not None:
            raise AssertionError('RViz ended before its window was seen')
        return len(self.screen().getcolors(WIDTH * HEIGHT)) > 100

    # Positions

    def calibrate(self, pixel: Tuple[int, int], place: Tuple[float, float]) -> None:
        """Notes that the map's `place` (m) is at `pixel`, where there is no handle."""
        self._nothing_here = pixel
        self._origin = (pixel[0] - place[0] * self._scale, pixel[1] + place[1] * self._scale)

    def pixel(self, x: float, y: float) -> Tuple[int, int]:
        """Returns the pixel of the place x, y (m, map)."""
        assert self._origin is not None, 'calibrate first'
        return (round(self._origin[0] + x * self._scale), round(self._origin[1] - y * self._scale))

    # Mouse actions

    def tool(self, key: str) -> None:
        """Chooses a tool by its shortcut: c Publish Point, g 2D Nav Goal, p 2D Pose Estimate."""
        self._screen.mouse('mousemove', WIDTH // 2, 95)

        def taken() -> bool:
            # A key is lost if it comes before the window has the keyboard focus. And a slow RViz
            # may still show the previous tool after `i`. If this is the tool that `key` chooses,
            # the toolbar does not change.
            self._screen.mouse('key', 'i')
            interact = self._at_rest(TOOLBAR)
            self._screen.mouse('key', key)
            return self._at_rest(TOOLBAR) != interact
        wait_until(taken, PATIENCE, f'RViz takes tool {key}')

    def tool_at(self, x: int) -> None:
        """Chooses the tool at `x` in the toolbar. A shortcut finds only one of two tools of the
        same kind.
        """
        self._screen.mouse('mousemove', x, TOOLBAR_Y, 'click', 1)

    def hover(self, pixel: Tuple[int, int]) -> None:
        """Moves the mouse to `pixel`, with a small movement at the end, like a hand."""
        self._screen.mouse('mousemove', pixel[0] - 2, pixel[1])
        self._screen.mouse('mousemove', *pixel)

    def click(self, pixel: Tuple[int, int], button: int = 1) -> None:
        self.hover(pixel)
        self._screen.mouse('click', button)

    def click_handle(self, pixel: Tuple[int, int], button: int = 1) -> None:
        """Clicks on a handle when RViz describes the handle in its status bar."""
        self.find_handle(pixel)
        self._screen.mouse('click', button)

    def drag_handle(self, start: Tuple[int, int], end: Tuple[int, int]) -> None:
        """Drags a handle that RViz has found, with small movements, like a hand."""
        self.find_handle(start)
        self._screen.mouse('mousedown', 1)
        for step in range(1, 11):
            self._screen.mouse('mousemove', start[0] + (end[0] - start[0]) * step // 10,
                               start[1] + (end[1] - start[1]) * step // 10)
        self._at_rest(STATUS_BAR)
        self._screen.mouse('mouseup', 1)

    def find_handle(self, pixel: Tuple[int, int]) -> None:
        """Moves the mouse to a handle, until RViz describes the handle in its status bar."""
        def found() -> bool:  # RViz checks at most once per frame, and only if the mouse moves
            for _ in range(2):  # at first the status bar can still describe the previous handle
                self.hover(self._nothing_here)
                idle = self._at_rest(STATUS_BAR)
            self.hover(pixel)
            return self._at_rest(STATUS_BAR) != idle
        wait_until(found, PATIENCE, f'RViz finds the handle at {pixel}')

    def drag(self, start: Tuple[int, int], end: Tuple[int, int]) -> None:
        self.hover(start)
        self._screen.mouse('mousedown', 1)
        self._screen.mouse('mousemove', (start[0] + end[0]) // 2, (start[1] + end[1]) // 2)
        self._screen.mouse('mousemove', *end)
        self._screen.mouse('mouseup', 1)

    def choose_from_menu(self, pixel: Tuple[int, int], menu: Sequence, entry: object) -> None:
        """Opens the `menu` of the handle at `pixel`, and clicks on one of its entries.

        A menu is recognised by its window, because its colour is also the colour of a white floor.
        """
        def lit() -> bool:
            nonlocal opened
            if opened not in self._screen.windows().items():  # the menu has closed: try again
                opened = self._open_menu(pixel)
            left, top, _, bottom = opened[1]
            y = top + round((menu.index(entry) + 0.5) * (bottom - top) / len(menu))
            self.hover((left + 2 * MENU_INSET, y))
            return count_near(self.screen(), (left + MENU_INSET, y), MENU_COLOUR, reach=1) == 0
        opened = self._open_menu(pixel)
        wait_until(lit, PATIENCE, f'{entry} of the menu at {pixel} is lit')
        self._screen.mouse('click', 1)
        wait_until(lambda: opened not in self._screen.windows().items(), PATIENCE,
                   f'the menu at {pixel} closes')

    def _open_menu(self, pixel: Tuple[int, int]) -> Tuple[str, Box]:
        """Opens the menu of the handle at `pixel`. Returns the menu's window."""
        before = self._screen.windows()

        def opened() -> Optional[Tuple[str, Box]]:
            for id, box in self._screen.windows().items():
                if id not in before and math.dist(box[:2], pixel) < MENU_INSET:
                    return id, box
            return None
        self.click_handle(pixel, button=3)
        return wait_until(opened, PATIENCE, f'the menu at {pixel}')

    def _part(self, box: Box) -> bytes:
        return self.screen().crop(box).tobytes()

    def _at_rest(self, box: Box) -> bytes:
        """Returns a part of the window when it has not changed for REST."""
        shot, since = self._part(box), time.monotonic()

        def rests() -> bool:
            nonlocal shot, since
            now = self._part(box)
            if now != shot:
                shot, since = now, time.monotonic()
            return time.monotonic() - since > REST
        wait_until(rests, PATIENCE, 'RViz comes to rest')
        return shot

    # Visible content

    def screen(self) -> Image.Image:
        """Returns a picture of the screen now."""
        return self._screen.picture()

    def picture(self, name: str) -> Image.Image:
        """Returns a picture of the screen now, and saves it among the artefacts as `name`.png."""
        picture = self.screen()
        picture.save(os.path.join(self._artefacts, f'{name}.png'))
        return picture

    def wait_for_picture(self, name: str, missing: Callable[[Image.Image], List[str]],
                         timeout: float = PATIENCE) -> None:
        """Waits until `missing` returns no more names. Saves the last picture as `name`.png."""
        picture, lacking = self.screen(), ['']

        def complete() -> bool:
            nonlocal picture, lacking
            picture = self.screen()
            lacking = missing(picture)
            return not lacking
        try:
            wait_until(complete, timeout, f'all that is to be seen in {name}.png')
        except AssertionError as error:
            raise AssertionError(f'{error}; missing: {"; ".join(lacking)}') from None
        finally:
            picture.save(os.path.join(self._artefacts, f'{name}.png'))


def close_to(pixels: np.ndarray, colour: Colour, tolerance: float = 40.0) -> np.ndarray:
    """Returns a mask of the `pixels` (..., 3) that have about this colour."""
    return np.linalg.norm(pixels.astype(float) - np.array(colour, float), axis=-1) <= tolerance


def count_near(picture: Image.Image, pixel: Tuple[int, int], colour: Colour, reach: int = 6,
               tolerance: float = 40.0) -> int:
    """Returns the number of pixels within `reach` of `pixel` that have about this colour."""
    x, y = pixel
    box = picture.crop((x - reach, y - reach, x + reach + 1, y + reach + 1))
    return int(close_to(np.asarray(box), colour, tolerance).sum())


class RvizTestCase(unittest.TestCase):
    """One RViz for all tests of a class. If programs are missing, the tests are skipped."""

    missing: List[str] = []

    @classmethod
    def setUpClass(cls) -> None:
        cls.missing = missing_programs()
        if cls.missing:
            return
        try:
            cls.set_up()
        except BaseException:
            # rosunit hides output that comes before the first test
            traceback.print_exc(file=sys.__stderr__)
            raise

    @classmethod
    def set_up(cls) -> None:
        """Starts the programs that the tests need."""
        raise NotImplementedError

    def setUp(self) -> None:
        if self.missing:
            self.skipTest(f'not installed: {", ".join(self.missing)}')
