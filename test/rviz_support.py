"""A real RViz in a screen of its own: places of the map on it, clicks on them, pictures of them.

The screen is an Xvfb of 1280 x 900; the mouse is xdotool's. Where a program is missing,
`missing_programs` says which.
"""
from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import traceback
from typing import Callable, List, Optional, Tuple

import numpy as np
from PIL import Image

from system_support import wait_until

PROGRAMS = ('Xvfb', 'xdotool', 'import', 'roslaunch')
RVIZ = ('/usr/bin/rviz', '/opt/ros/noetic/bin/rviz')
WIDTH, HEIGHT = 1280, 900
TOOLBAR_Y = 42
TOOLBAR = (0, 24, 1000, 60)
MENU_REACH = 14  # pixels from the click to the inside of the menu
STATUS_BAR = (0, 872, 1100, 900)
Colour = Tuple[int, int, int]
MENU_COLOUR: Colour = (239, 239, 239)


def missing_programs() -> List[str]:
    """Programs that these tests need and that are not here."""
    missing = [name for name in PROGRAMS if shutil.which(name) is None]
    return missing if shutil.which('rviz') or any(map(os.path.exists, RVIZ)) else [*missing, 'rviz']


class Screen:
    """An X server without a monitor, with one mouse and one keyboard."""

    def __init__(self) -> None:
        read_end, write_end = os.pipe()
        self._server = subprocess.Popen(
            ['Xvfb', '-displayfd', str(write_end), '-screen', '0', f'{WIDTH}x{HEIGHT}x24',
             '+extension', 'GLX', '-nolisten', 'tcp'],
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

    def run(self, *command: str) -> str:
        return subprocess.run(command, env=self.environment, check=True, timeout=30,
                              stdout=subprocess.PIPE, text=True).stdout

    def mouse(self, *command: object) -> None:
        self.run('xdotool', *map(str, command))

    def picture(self, path: str) -> Image.Image:
        self.run('import', '-window', 'root', path)
        return Image.open(path).convert('RGB')


class RvizWindow:
    """RViz as launch/rviz.launch starts it, filling the screen."""

    def __init__(self, screen: Screen, artefacts: str, scale: float, *launch: str) -> None:
        """`scale` is that of the configuration's view, pixels per metre."""
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
        colours = self.picture('rviz_starting').getcolors(WIDTH * HEIGHT)
        return len(colours) > 100

    # Where things are

    def calibrate(self, pixel: Tuple[int, int], place: Tuple[float, float]) -> None:
        """The map's `place` (m) is known to be at `pixel`, where no handle is."""
        self._nothing_here = pixel
        self._origin = (pixel[0] - place[0] * self._scale, pixel[1] + place[1] * self._scale)

    def pixel(self, x: float, y: float) -> Tuple[int, int]:
        """Where the place x, y (m, map) is on the screen."""
        assert self._origin is not None, 'calibrate first'
        return (round(self._origin[0] + x * self._scale), round(self._origin[1] - y * self._scale))

    # What the mouse does

    def tool(self, key: str) -> None:
        """Choose a tool by its shortcut: c Publish Point, g 2D Nav Goal, p 2D Pose Estimate."""
        self._screen.mouse('mousemove', WIDTH // 2, 95)
        self._screen.mouse('key', 'i')
        interact = self._at_rest(TOOLBAR)
        self._screen.mouse('key', key)
        wait_until(lambda: self._at_rest(TOOLBAR) != interact, 10.0, f'RViz takes tool {key}')

    def tool_at(self, x: int) -> None:
        """Choose the tool at `x` of the toolbar: of two of a kind a shortcut finds one only."""
        self._screen.mouse('mousemove', x, TOOLBAR_Y, 'click', 1)

    def hover(self, pixel: Tuple[int, int]) -> None:
        """Bring the mouse to `pixel`, with a small move there, as a hand does."""
        self._screen.mouse('mousemove', pixel[0] - 2, pixel[1])
        self._screen.mouse('mousemove', *pixel)

    def click(self, pixel: Tuple[int, int], button: int = 1) -> None:
        self.hover(pixel)
        self._screen.mouse('click', button)

    def click_handle(self, pixel: Tuple[int, int], button: int = 1) -> None:
        """Click on a handle once RViz says in its status bar what is under the mouse."""
        self.hover(self._nothing_here)
        idle = self._at_rest(STATUS_BAR)
        self.hover(pixel)
        wait_until(lambda: self._at_rest(STATUS_BAR) != idle, 10.0,
                   f'RViz finds the handle at {pixel}')
        self._screen.mouse('click', button)

    def _at_rest(self, box: Tuple[int, int, int, int]) -> bytes:
        """The picture of a part of the window, taken when it has come to rest."""
        shots = [b'', b'']

        def rests() -> bool:
            shots[:] = [shots[1], self.picture('rviz_part').crop(box).tobytes()]
            return shots[0] == shots[1]
        wait_until(rests, 10.0, 'RViz comes to rest')
        return shots[0]

    def drag(self, start: Tuple[int, int], end: Tuple[int, int]) -> None:
        self.hover(start)
        self._screen.mouse('mousedown', 1)
        self._screen.mouse('mousemove', (start[0] + end[0]) // 2, (start[1] + end[1]) // 2)
        self._screen.mouse('mousemove', *end)
        self._screen.mouse('mouseup', 1)

    def choose_from_menu(self, pixel: Tuple[int, int], entry: int) -> None:
        """Open the menu of the handle at `pixel` and choose its `entry`, counted from 1."""
        self.click_handle(pixel, button=3)
        below = (pixel[0] + MENU_REACH, pixel[1] + MENU_REACH)
        wait_until(lambda: count_near(self.picture('rviz_menu'), below, MENU_COLOUR) > 50, 10.0,
                   f'the menu at {pixel}')
        self._screen.mouse('key', *['Down'] * entry, 'Return')

    # What is to be seen

    def picture(self, name: str) -> Image.Image:
        """A picture of the screen, kept among the artefacts as `name`.png."""
        return self._screen.picture(os.path.join(self._artefacts, f'{name}.png'))

    def wait_for_picture(self, name: str, seen: Callable[[Image.Image], bool], what: str,
                         timeout: float = 20.0) -> Image.Image:
        """Takes pictures until one satisfies `seen`; the last one is kept."""
        last: List[Image.Image] = []

        def is_seen() -> bool:
            last[:] = [self.picture(name)]
            return seen(last[0])
        wait_until(is_seen, timeout, f'{what} in {name}.png')
        return last[0]


def close_to(pixels: np.ndarray, colour: Colour, tolerance: float = 40.0) -> np.ndarray:
    """Which of the `pixels` (..., 3) are about of that colour."""
    return np.linalg.norm(pixels.astype(float) - np.array(colour, float), axis=-1) <= tolerance


def count_near(picture: Image.Image, pixel: Tuple[int, int], colour: Colour, reach: int = 6,
               tolerance: float = 40.0) -> int:
    """How many pixels within `reach` of `pixel` are about of that colour."""
    x, y = pixel
    box = picture.crop((x - reach, y - reach, x + reach + 1, y + reach + 1))
    return int(close_to(np.asarray(box), colour, tolerance).sum())


def report_failure(set_up: Callable[[], None]) -> None:
    """Calls `set_up` and tells what went wrong: rosunit swallows it before the first test."""
    try:
        set_up()
    except BaseException:
        traceback.print_exc(file=sys.__stderr__)
        raise
