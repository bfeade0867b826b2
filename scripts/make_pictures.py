#!/usr/bin/env python3
"""Makes the pictures of the README: a real RViz shows the simulated robot; a mouse clicks in RViz.

After `source devel/setup.bash`: `PYTHONPATH=test:$PYTHONPATH scripts/make_pictures.py`

Writes rviz_map.png, rviz_route.png, rviz_drive.gif, made_graph.png, graph_editor.png, fleet.gif,
fleet_work.png, page_map.png and page_missions.png into docs/images. With an argument it writes only
some of them: `stack` writes the first three, `graph` the next two, `fleet` and `work` one each, and
`page` the last two.
"""
from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path
from typing import Callable, Iterator, List, Optional, Tuple

import rosgraph
import rospy
from fleet_support import Factory, free_fleet_ports
from geometry_msgs.msg import PointStamped
from PIL import Image, ImageDraw
from rviz_support import RvizWindow, Screen, count_near, missing_programs
from std_msgs.msg import String

from graph_editor import make_cli
from itrci_nav_msgs.msg import ExecutionRouteStates, FleetRobot, TargetRoute
from omron_map import MapDocument
from ports import free_port
from system_support import Recorder, connected_publisher, wait_until

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / 'src/fleet_page/test'))
from browser import Browser  # noqa: E402

IMAGES = ROOT / 'docs/images'
VIEW = (16, 62, 1264, 870)  # the 3D view in the window
WINDOW = (0, 0, 1280, 871)
GIF_WIDTH, GIF_COLOURS = 900, 160
SCALE = 40.0
NOTHING_HERE = (640, 440)
# s between two pictures of the film, and how many times as fast as reality the film runs
PERIOD, SPEED_UP = 1.0, 5.0
STATION_SIDE = '-13.2,-7.0,180'  # where the laboratory's charger is
VERTEX_2 = (600, 198)  # pixel of a vertex of the made graph
NAVY, YELLOW = (31, 51, 89), (255, 217, 26)
FLEET_FILM = 45.0  # s
PALLETS = 5  # enough for a queue of robots at the press
PAGE_SIZE = (1440, 900)
AREA = '33 34'  # edges of the southern shelf
CHOSEN = 'ld90_3'  # the robot whose laser the page shows
DOOR = 17  # edge through the door of the press
CORNER = (1240, 860)  # pixel at which the mouse pointer hides nothing
ROUTE = (9, 3, 4, 31, 32, 34)  # edges from vertex 4 to 52


class Film:
    """Pictures of the 3D view. A ring shows where the mouse has just clicked."""

    def __init__(self, window: RvizWindow) -> None:
        self._window = window
        self._pictures: List[Image.Image] = []

    def take(self, click: Optional[Tuple[int, int]] = None) -> None:
        """Takes one picture; `click` is the pixel that was just clicked."""
        picture = self._window.screen()
        if click is not None:
            pen = ImageDraw.Draw(picture)
            for radius in (16, 24):
                pen.ellipse([click[0] - radius, click[1] - radius, click[0] + radius,
                             click[1] + radius], outline=(255, 255, 255), width=3)
        view = picture.crop(VIEW)
        self._pictures.append(view.resize((GIF_WIDTH, round(GIF_WIDTH * view.height / view.width))))

    def take_until(self, done: Callable[[], bool], longest: float) -> None:
        """Takes pictures at an even pace until `done`, for at most `longest` s."""
        end = time.monotonic() + longest
        while not done() and time.monotonic() < end:
            begun = time.monotonic()
            self.take()
            time.sleep(max(0.0, begun + PERIOD - time.monotonic()))

    def save(self, path: Path) -> None:
        """Saves the film with one palette, because unchanged parts then need no space."""
        palette = self._pictures[len(self._pictures) // 2].quantize(GIF_COLOURS, Image.MAXCOVERAGE)
        frames = [picture.quantize(palette=palette, dither=0) for picture in self._pictures]
        frames[0].save(path, save_all=True, append_images=frames[1:], loop=0, optimize=True,
                       duration=round(1000 * PERIOD / SPEED_UP))


def keep(window: RvizWindow, name: str) -> None:
    """Saves a picture of the window without its status bar."""
    window.screen().crop(WINDOW).save(IMAGES / f'{name}.png', optimize=True)


def film(window: RvizWindow) -> None:
    """Clicks on a goal, and films the robot until it arrives. Then films a route of the fleet
    manager.
    """
    lab = MapDocument.load(str(ROOT / 'maps/lab.map'))
    clicks = Recorder('/clicked_point', PointStamped)
    lines = Recorder('/omron_ld90/arcl_response', String)
    states = Recorder('/omron_ld90/execution_route_states', ExecutionRouteStates)
    routes = connected_publisher('/omron_ld90/target_route', TargetRoute)
    lines.wait_for(lambda line: True, 30.0, 'answer of the robot')

    def calibrated() -> bool:
        window.tool('c')
        window.click(NOTHING_HERE)
        return bool(clicks.messages)
    wait_until(calibrated, 60.0, 'a click lands')
    point = clicks.messages[0].point
    window.calibrate(NOTHING_HERE, (point.x, point.y))
    time.sleep(9.0)  # until the text about the click has disappeared
    keep(window, 'rviz_map')

    pictures = Film(window)
    goal = lab.find('4')
    assert goal is not None
    pixel = window.pixel(goal.x / 1000.0, goal.y / 1000.0)
    pictures.take()
    window.tool('c')
    window.click(pixel)
    pictures.take(pixel)
    pictures.take_until(lambda: any(line.data == 'Arrived at 4' for line in lines.messages), 60.0)
    pictures.take_until(lambda: False, 1.0)
    routes.publish(TargetRoute(route_id=7, edges=list(ROUTE)))

    def done() -> int:
        last: List = states.messages[-1:]
        return sum(edge.state == edge.COMPLETE for edge in last[0].edge_states) if last else 0
    pictures.take_until(lambda: done() == 3, 60.0)
    keep(window, 'rviz_route')
    pictures.take_until(lambda: done() == len(ROUTE), 90.0)
    pictures.take_until(lambda: False, 2.0)
    pictures.save(IMAGES / 'rviz_drive.gif')


def graph_pictures(screen: Screen) -> None:
    """Takes pictures of the graph made from the laboratory's bare map: drawn, and in the editor."""
    lab = str(ROOT / 'maps' / 'lab_base.map')
    with tempfile.TemporaryDirectory() as folder:
        graph = f'{folder}/graph.yaml'
        make_cli.main(['--map', lab, '--output', graph, f'--dock={STATION_SIDE}',
                       '--draw', str(IMAGES / 'made_graph.png')])
        port = free_port()
        os.environ['ROS_MASTER_URI'] = screen.environment['ROS_MASTER_URI'] = (
            f'http://127.0.0.1:{port}')
        editor = subprocess.Popen(
            ['roslaunch', '-p', str(port), 'graph_editor', 'edit.launch', 'rviz:=false',
             f'map_file:={lab}', f'graph_file:={graph}'],
            env=screen.environment, stdout=subprocess.DEVNULL)
        window = None
        try:
            window = RvizWindow(screen, str(IMAGES), SCALE, 'graph_editor', 'editor_rviz.launch',
                                f'map_file:={lab}')
            wait_until(lambda: count_near(window.screen(), VERTEX_2, NAVY), 60.0, 'the graph')
            window.click(VERTEX_2)
            wait_until(lambda: count_near(window.screen(), VERTEX_2, YELLOW, 12), 60.0,
                       'the selected vertex')
            keep(window, 'graph_editor')
        finally:
            if window is not None:
                window.close()
            editor.send_signal(signal.SIGINT)
            editor.wait(30)


def fleet_film(screen: Screen) -> None:
    """Films eight robots at work, started like `scripts/run.sh fleet:=4 longest_edge:=1.5
    demo:=true`.
    """
    with fleet_in_rviz(screen, 'longest_edge:=1.5', 'demo:=true') as (fleet, window):
        wait_until(lambda: sum(robot.has_mission for robot in fleet.state.messages[-1].robots) == 8,
                   120.0, 'eight missions')
        window.hover(CORNER)
        pictures = Film(window)
        pictures.take_until(lambda: False, FLEET_FILM)
        pictures.save(IMAGES / 'fleet.gif')


def work_picture(screen: Screen) -> None:
    """Takes a picture of doors, and of a station with a queue, from a fleet that is started like
    `scripts/run.sh fleet:=4 work:=true`.
    """
    with fleet_in_rviz(screen, 'work:=true') as (fleet, window):
        for _ in range(PALLETS):
            subprocess.run(['rosrun', 'graph_fleet_manager', 'mission', 'run', 'pallet',
                            'from:=press', 'to:=shelves'], check=True, stdout=subprocess.DEVNULL)
        window.hover(CORNER)

        def is_busy() -> bool:
            state = fleet.state.messages[-1]
            queue = sum('its turn at station press' in robot.waits_for for robot in state.robots)
            is_in_door = any(abs(robot.pose.edge_id) == DOOR and 20.0 < robot.pose.percentage < 60.0
                             for robot in state.robots)
            return is_in_door and queue > 1
        wait_until(is_busy, 300.0, 'a robot in the door, and robots in the queue of the press')
        keep(window, 'fleet_work')


def page_pictures(_: Screen) -> None:
    """Takes pictures of the fleet page at work: the map with its layers, and a wide panel with the
    missions.
    """
    ports = free_fleet_ports()
    with running_fleet('work:=true', 'lasers:=true', 'page:=true', f'page_port:={ports + 9}',
                       first_port=ports) as fleet:
        fleet.state.wait_for(lambda state: state.robots and all(
            robot.outage_code == FleetRobot.OUTAGE_NONE for robot in state.robots), 120.0,
            'fleet whose robots can all work')
        for ends in (('press', 'shelves'), ('shelves', 'packing')) * 3:
            subprocess.run(['rosrun', 'graph_fleet_manager', 'mission', 'run', 'pallet',
                            f'from:={ends[0]}', f'to:={ends[1]}'], check=True,
                           stdout=subprocess.DEVNULL)
        window = Browser(*PAGE_SIZE)
        try:
            window.resize(*PAGE_SIZE)
            window.open(f'http://127.0.0.1:{ports + 9}/')
            window.one('.robot')
            window.click('#tab_button_edges')
            window.one('#edge').send_keys(AREA)
            window.one('#area_name').send_keys('Loading bay')
            window.click('#keep_area')
            window.click('#tab_button_robots')
            window.click(f'#robots [data-key={CHOSEN}] [data-act=choose]')
            window.click('#layers_button')
            for layer in ('allocation', 'laser'):
                window.click(f'[data-layer={layer}]')
            window.click('#layers_button')
            window.wait(lambda: window.one('.laser').get_attribute('d'), 'the laser')
            wait_until(lambda: sum(robot.has_mission for robot in
                                   fleet.state.messages[-1].robots) >= 5, 120.0, 'missions')
            wait_until(lambda: any('its turn at station' in robot.waits_for for robot in
                                   fleet.state.messages[-1].robots), 120.0, 'a queue')
            wait_until(lambda: not window.one('#said').is_displayed(), 30.0, 'no answer any more')
            window.driver.save_screenshot(str(IMAGES / 'page_map.png'))
            window.click('#theme')
            window.click('#tab_button_missions')
            window.click('#new_mission summary')
            window.click('#timetables_box summary')
            window.click('#widen')
            time.sleep(PERIOD)  # the map has its new size
            window.driver.save_screenshot(str(IMAGES / 'page_missions.png'))
        finally:
            window.close()


@contextmanager
def running_fleet(*options: str, **more: int) -> Iterator[Factory]:
    """Yields eight running robots under a separate ROS master."""
    port = free_port()
    os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{port}'
    master = subprocess.Popen(['roscore', '-p', str(port)], stdout=subprocess.DEVNULL)
    fleet = None
    try:
        wait_until(rosgraph.Master('/make_pictures').is_online, 60.0, 'the ROS master')
        rospy.init_node('make_pictures', disable_signals=True)
        fleet = Factory('4', *options, **more)
        yield fleet
    finally:
        if fleet is not None:
            fleet.stop()
        master.send_signal(signal.SIGINT)
        master.wait(30)


@contextmanager
def fleet_in_rviz(screen: Screen, *options: str) -> Iterator[Tuple[Factory, RvizWindow]]:
    """Yields a running fleet, and an RViz that shows it."""
    with running_fleet(*options) as fleet:
        screen.environment['ROS_MASTER_URI'] = os.environ['ROS_MASTER_URI']
        window = RvizWindow(screen, str(IMAGES), SCALE, 'omron_ld90', 'rviz.launch',
                            'robot_name:=rviz_of_fleet', f'map_file:={fleet.folder}/fleet.map',
                            f'rviz_config:={fleet.folder}/fleet.rviz')
        try:
            fleet.wait_until_ready()
            yield fleet, window
        finally:
            window.close()


def main() -> int:
    """Starts the programs on free ports, films them, and ends them."""
    missing = missing_programs()
    if missing:
        print(f'Not installed: {", ".join(missing)}.', file=sys.stderr)
        return 1
    IMAGES.mkdir(parents=True, exist_ok=True)
    parts = {'stack': stack_pictures, 'graph': graph_pictures, 'fleet': fleet_film,
             'work': work_picture, 'page': page_pictures}
    if sys.argv[1:] not in [[name] for name in parts]:
        for name in parts:  # each part in a separate process, because a process has one ROS master
            subprocess.run([sys.executable, __file__, name], check=True)
        return 0
    screen = Screen()
    try:
        parts[sys.argv[1]](screen)
    finally:
        screen.close()
    return 0


def stack_pictures(screen: Screen) -> None:
    """Takes pictures of the stack with a simulated robot, on ports that only this run uses."""
    port = free_port()
    os.environ['ROS_MASTER_URI'] = screen.environment['ROS_MASTER_URI'] = (
        f'http://127.0.0.1:{port}')
    stack = subprocess.Popen(
        ['roslaunch', '-p', str(port), 'omron_ld90', 'full_stack.launch', 'rviz:=false',
         f'arcl_port:={free_port()}', f'outgoing_port:={free_port()}'], stdout=subprocess.DEVNULL)
    window = None
    try:
        wait_until(rosgraph.Master('/make_pictures').is_online, 120.0, 'the ROS master')
        rospy.init_node('make_pictures', disable_signals=True)
        window = RvizWindow(screen, str(IMAGES), SCALE, 'omron_ld90', 'rviz.launch', 'tools:=/')
        film(window)
    finally:
        if window is not None:
            window.close()
        stack.send_signal(signal.SIGINT)
        stack.wait(30)


if __name__ == '__main__':
    sys.exit(main())
