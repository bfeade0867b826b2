#!/usr/bin/env python3
"""The fleet page in a real Chromium, with simulated robots: each act from the click to the robot.

The effect of an act is checked in the true positions of the simulator, and in the messages of the
fleet manager.
"""
from __future__ import annotations

import json
import math
import os
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request
from pathlib import Path
from typing import Set

import rospkg
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from fleet_support import READY, Factory, Place, Simulators, free_fleet_ports

from fleet_page.core.acts import ActKind
from fleet_requests import mission_request
from itrci_nav_msgs.msg import (
    ClosedEdges,
    FleetRobot,
    MissionRequest,
    MissionStatus,
    MissionStep,
    MissionStop,
    Timetables,
)
from node_lifecycle.watchdog import STANDSTILL
from system_support import Recorder, connected_publisher, kill_node, run_cases, wait_until

sys.path.insert(0, os.path.join(rospkg.RosPack().get_path('fleet_page'), 'test'))
from browser import MISSING, Browser  # noqa: E402

SPEED = 4.0
FLEET = '''clearance: 0.1
robot_types:
- {name: agv, radius: 0.4, speed: 1.0, obeys_edge_speed: false}
- {name: guest, radius: 0.4, speed: 1.0}
robots:
- {name: agv_1, type: agv, vertex: 8, driver: agv}
- {name: agv_2, type: agv, vertex: 14, driver: agv}
- {name: visitor, type: guest, vertex: 39, driver: none}
'''
WORK = '''templates:
- name: visit
  parameters: [to]
  stops:
  - {at: $to}
timetables:
- {name: night, template: visit, arguments: {to: 6}, every: 24 h, from: "03:00"}
'''
FIRST, SECOND, AWAY = 'agv_1', 'agv_2', 'visitor'
NEAR = 0.2  # m


class FleetOnThePage(unittest.TestCase):
    """One fleet and one browser. The tests are the parts of one story, in this order."""

    @classmethod
    def setUpClass(cls) -> None:
        if MISSING:
            raise unittest.SkipTest(MISSING)
        ports = free_fleet_ports()
        with tempfile.NamedTemporaryFile('w', suffix='.yaml', delete=False) as file:
            file.write(FLEET)
        cls.fleet_file, cls.url = Path(file.name), f'http://127.0.0.1:{ports + 9}/'
        cls.work_file = Path(f'{file.name}.work')
        cls.work_file.write_text(WORK)
        cls.factory = Factory(file.name, 'page:=true', f'page_port:={ports + 9}',
                              f'sim_speed:={SPEED}', f'work_file:={cls.work_file}',
                              first_port=ports)
        try:
            cls.closed = Recorder('/closed_edges_in_force', ClosedEdges)
            cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
            cls.requests = Recorder('/mission_request', MissionRequest)
            cls.timetables = Recorder('/timetables', Timetables)
            cls.window = Browser()
            wait_until(cls.is_served, 40.0, f'the page at {cls.url}')
            cls.window.open(cls.url)
            cls.factory.state.wait_for(
                lambda state: sum(robot.state in READY for robot in state.robots) == 2, 40.0,
                'fleet in which two robots are ready')
            cls.simulators = Simulators((ports + 3,))
        except BaseException:
            cls.factory.stop()
            if hasattr(cls, 'window'):
                cls.window.close()
            raise

    @classmethod
    def tearDownClass(cls) -> None:
        cls.window.close()
        cls.factory.stop()
        cls.fleet_file.unlink()
        cls.work_file.unlink()

    @classmethod
    def is_served(cls) -> bool:
        """Returns whether the page answers."""
        try:
            return bool(urllib.request.urlopen(f'{cls.url}api/me', timeout=1).status == 200)
        except OSError:
            return False

    # --- the story -------------------------------------------------------------------------------

    def test_1_a_robot_that_is_away_is_an_alarm_and_is_declared_absent(self) -> None:
        self.window.click(f'#alarm_list [data-key="robot:{AWAY}"] [data-act=acknowledge]')
        self.window.wait(lambda: 'seen by local' in self.window.text('#alarms'), 'who has seen it')
        self.window.click('#tab_button_robots')
        self.robot_button(AWAY, ActKind.ABSENT)
        self.window.driver.switch_to.alert.accept()
        self.factory.wait_for_state(AWAY, FleetRobot.ABSENT)

    def test_2_a_mission_of_clicks_is_driven_held_and_changed(self) -> None:
        mission = self.send(27, 18, robot=FIRST, first_stay=True, priority=3)
        request = self.requests.wait_for(lambda one: one.request_id == mission, 10.0, 'request')
        self.assertEqual((FIRST, 3, (-1.0, 0.0)),
                         (request.robot, request.priority, tuple(request.dwell)))
        self.wait_at(FIRST, 27)
        wait_until(lambda: 'release' in self.factory.robot(FIRST).waits_for, 20.0,
                   f'{FIRST} stays until it is released')
        self.choose_act(mission, ActKind.RELEASE.value)
        self.wait_until_moved(FIRST)
        self.choose_act(mission, ActKind.PAUSE.value)
        self.wait_for_status(mission, MissionStatus.PAUSED)
        self.wait_until_standing(FIRST)
        self.choose_act(mission, ActKind.CONTINUE.value)
        self.wait_until_moved(FIRST)
        self.choose_act(mission, 'change')
        destinations = self.window.one('#open form input:not([type])')
        destinations.clear()
        destinations.send_keys('6')
        self.window.click('#open form button')
        self.wait_at(FIRST, 6)
        self.wait_for_status(mission, MissionStatus.SUCCEEDED)

    def test_3_a_favourite_is_kept_used_and_removed_and_its_mission_cancelled(self) -> None:
        self.compose(52, robot=FIRST)
        self.window.one('#favourite_name').send_keys('far')
        self.window.click('#keep')
        self.window.one('#favourites [data-act=use]')
        self.window.click('#clear')
        self.window.click('#favourites [data-act=use]')
        mission = self.press_send()
        self.wait_until_moved(FIRST)
        self.choose_act(mission, ActKind.CANCEL.value)
        self.wait_for_status(mission, MissionStatus.CANCELLED)
        self.wait_until_standing(FIRST)
        self.assertGreater(self.distance(FIRST, 52), 1.0)
        self.window.click('#favourites [data-act=remove]')
        self.window.wait(lambda: not self.window.text('#favourites'), 'no favourites')

    def test_4_a_step_of_a_person_ends_by_a_button(self) -> None:
        step = MissionStep(type='look', actor=MissionStep.PERSON, timeout=60.0)
        request = mission_request((), robot=FIRST, stops=[MissionStop(vertex=27, steps=[step])])
        mission = request.request_id
        # the publisher must wait for path_supervisor, because the page also subscribes to the topic
        connected_publisher('/mission_request', MissionRequest, to='path_supervisor').publish(
            request)
        self.wait_at(FIRST, 27)
        self.window.click('#tab_button_missions')
        self.window.click(f'{self.row_of(mission)} [data-act=answer_done]')
        self.wait_for_status(mission, MissionStatus.SUCCEEDED)

    def test_5_nobody_drives_a_closed_edge_and_an_open_one_is_driven(self) -> None:
        self.window.click('#tab_button_edges')
        self.window.one('#edge').send_keys('2')
        self.window.click('#close_edge')
        wait_until(lambda: list(self.closed.messages[-1].edges) == [2], 10.0, 'edge 2 is closed')
        self.assertNotIn(2, self.edges_driven(SECOND, 10))
        self.window.click('#tab_button_edges')
        self.window.click('#closed [data-act=open]')
        wait_until(lambda: not self.closed.messages[-1].edges, 10.0, 'edge 2 is open')
        self.assertIn(2, self.edges_driven(SECOND, 14))
        self.window.click('#tab_button_edges')
        self.window.one('#edge').send_keys('2')
        self.window.one('#area_name').send_keys('gate')
        self.window.click('#keep_area')
        self.window.click('#areas [data-act=close]')
        wait_until(lambda: list(self.closed.messages[-1].edges) == [2], 10.0, 'the area is closed')
        listed = json.loads(subprocess.check_output(
            ['rosrun', 'graph_fleet_manager', 'edge', 'list', '--json'], timeout=30))
        self.assertEqual([{'area': 'gate', 'edges': [2], 'closed': 1}], listed['areas'])
        self.window.click('#areas [data-act=open]')
        wait_until(lambda: not self.closed.messages[-1].edges, 10.0, 'the area is open')
        self.window.click('#areas [data-act=remove_area]')
        self.window.wait(lambda: self.window.text('#areas') == '', 'the area is removed')

    def test_6_a_template_is_run_and_a_timetable_is_paused_and_resumed(self) -> None:
        self.window.click('#tab_button_missions')
        self.window.wait(lambda: self.window.one('#send_template').is_displayed(), 'templates')
        self.choose('send_template', 'visit')
        self.choose('send_robot', FIRST)
        self.window.click_vertex(18)
        mission = self.press_send()
        self.wait_at(FIRST, 18)
        self.wait_for_status(mission, MissionStatus.SUCCEEDED)
        self.choose('send_template', '')
        self.window.click('#timetables_box summary')
        self.window.wait(lambda: 'next' in self.window.text('#timetables'), 'the next run')
        for is_paused in (True, False):
            self.window.click('#timetables [data-act=pause]')
            wait_until(lambda: self.timetables.messages[-1].timetables[0].is_paused is is_paused,  # noqa: B023
                       10.0, 'the timetable is paused, or goes on')
            self.window.wait(lambda: ('paused' in self.window.text('#timetables')) is is_paused,  # noqa: B023
                             'the same on the page')

    def test_7_stop_stops_all_and_robots_go_out_of_service_and_in_again(self) -> None:
        self.send(33, 26, 33, 26, robot_type='agv', robot=SECOND)
        self.wait_until_moved(SECOND)
        self.assertEqual('', self.stop_bar())
        self.window.click('#stop')
        self.wait_until_standing(SECOND)
        self.the_stop_outlives_restarts()
        self.window.click('#resume')
        self.wait_until_moved(SECOND)
        self.window.wait(lambda: self.stop_bar() == '', 'no bar any more')
        self.window.picture('system')
        self.window.click('#tab_button_robots')
        self.robot_button(SECOND, ActKind.OUT)
        self.factory.wait_for_state(SECOND, FleetRobot.OUT_OF_SERVICE)
        self.wait_until_standing(SECOND)

        def is_back() -> bool:
            """Puts a robot back into service. The fleet manager refuses this until it is sure that
            the robot stands.
            """
            self.robot_button(SECOND, ActKind.IN)
            time.sleep(0.5)
            return self.factory.robot(SECOND).state in READY
        wait_until(is_back, 20.0, f'{SECOND} in service')

    def test_8_all_of_it_is_in_the_audit_list(self) -> None:
        with urllib.request.urlopen(f'{self.url}api/audit', timeout=5) as answer:
            rows = json.load(answer)['rows']
        done = {row['act'] for row in rows if row['ok']}
        self.assertEqual(set(), {kind.value for kind in ActKind} - done)
        self.assertEqual({'local'}, {row['person'] for row in rows})

    def test_9_no_thread_of_a_node_counted_as_blocked(self) -> None:
        states = [status for array in self.diagnostics.messages for status in array.status
                  if status.name.endswith(': threads')]
        first, last = (self.diagnostics.messages[at].header.stamp.to_sec() for at in (0, -1))
        self.assertGreater(last - first, 2 * STANDSTILL)
        self.assertGreaterEqual(len({status.name for status in states}), 4)
        self.assertEqual({status.message for status in states
                          if status.level != DiagnosticStatus.OK}, set())

    # --- the page --------------------------------------------------------------------------------

    def stop_bar(self) -> str:
        """Returns the words of the red bar; empty if the bar is not shown."""
        return str(self.window.script('''const bar = document.getElementById('stopped');
            return bar.hidden ? '' : bar.textContent;'''))

    def the_stop_outlives_restarts(self) -> None:
        """Checks that restarted programs still show who has stopped the fleet."""
        self.window.wait(lambda: ', by local (page).' in self.stop_bar(), 'the red bar')
        told = self.stop_bar()
        kill_node('/path_supervisor')
        self.factory.state.wait_for(
            lambda state: state.stop.by == 'local (page)', 30.0,
            'state of the new fleet manager', len(self.factory.state.messages))
        kill_node('/fleet_page')
        wait_until(self.is_served, 40.0, 'the page is back')
        self.window.open(self.url)
        self.window.wait(lambda: self.stop_bar() == told, 'the same bar')
        self.window.picture('stopped_system')
        self.factory.wait_for_state(SECOND, FleetRobot.BUSY)

    def compose(self, *vertices: int, robot: str = '', robot_type: str = '',
                first_stay: bool = False, priority: int = 0) -> None:
        """Clicks on the vertices on the map, and fills in the other fields."""
        self.window.click('#tab_button_missions')
        self.window.click('#clear')
        for count, vertex in enumerate(vertices, 1):
            self.window.click_vertex(vertex)
            self.window.wait(lambda: len(self.window.driver.find_elements(
                'css selector', '#chosen li')) == count, f'destination {vertex}')  # noqa: B023
        if first_stay:
            self.window.click('#chosen li:nth-child(1) input[type=checkbox]')
        for name, value in (('send_robot', robot), ('send_type', robot_type),
                            ('send_priority', str(priority))):
            self.choose(name, value)

    def choose(self, name: str, value: str) -> None:
        """Sets a field in the way that a person does."""
        self.window.script('''const field = document.getElementById(arguments[0]);
            field.value = arguments[1]; field.dispatchEvent(new Event('change'));''', name, value)

    def press_send(self) -> int:
        """Sends the composed mission. Returns its id when the fleet manager has accepted it."""
        known = len(self.factory.statuses.messages)
        self.window.click('#send_button')
        status = self.factory.statuses.wait_for(
            lambda status: status.state == MissionStatus.PENDING, 10.0, 'new mission', known)
        return int(status.request_id)

    def send(self, *vertices: int, robot: str = '', robot_type: str = '',
             first_stay: bool = False, priority: int = 0) -> int:
        """Composes a mission and sends it."""
        self.compose(*vertices, robot=robot, robot_type=robot_type, first_stay=first_stay,
                     priority=priority)
        return self.press_send()

    def row_of(self, mission: int) -> str:
        """Returns the selector of the row of an open mission."""
        return f'#open tr[data-key^="{mission}:"]'

    def choose_act(self, mission: int, act: str) -> None:
        """Chooses an act in the menu of a mission as soon as the mission's state allows the act."""
        def is_there() -> bool:
            self.window.click(f'{self.row_of(mission)} [data-act=menu]')
            found = self.window.driver.find_elements('css selector', f'#menu [data-act={act}]')
            for button in found:
                button.click()
            return bool(found)
        self.window.wait(is_there, act)

    def robot_button(self, robot: str, kind: ActKind) -> None:
        """Presses a button of a robot."""
        row = f'#robots li[data-key={robot}]'
        if not self.window.driver.find_elements('css selector', f'{row}.chosen'):
            self.window.click(f'{row} [data-act=choose]')
        self.window.click(f'{row} [data-act={kind.value}]')

    # --- the robots ------------------------------------------------------------------------------

    def place(self, robot: str) -> Place:
        """Returns the true position of the robot (m)."""
        return self.simulators.places()[robot]

    def distance(self, robot: str, vertex: int) -> float:
        """Returns the distance (m) from the robot to a vertex."""
        there = self.factory.graph.vertices[vertex]
        return math.dist(self.place(robot), (there.x, there.y))

    def wait_at(self, robot: str, vertex: int) -> None:
        """Waits until the robot is at the vertex."""
        wait_until(lambda: self.distance(robot, vertex) < NEAR, 30.0, f'{robot} at {vertex}')

    def wait_until_moved(self, robot: str) -> None:
        """Waits until the robot drives."""
        before = self.place(robot)
        wait_until(lambda: math.dist(self.place(robot), before) > NEAR, 20.0, f'{robot} drives')

    def wait_until_standing(self, robot: str) -> None:
        """Waits until the robot has stood for a moment."""
        stood = [self.place(robot)]

        def stands() -> bool:
            time.sleep(0.3)
            stood.append(self.place(robot))
            return math.dist(stood[-1], stood[-2]) < 0.01
        wait_until(stands, 20.0, f'{robot} stands')

    def wait_for_status(self, mission: int, state: int) -> None:
        """Waits until the fleet manager reports this state."""
        wait_until(lambda: self.factory.status_of(mission) == state, 20.0,
                   f'mission {mission} in state {state}')

    def edges_driven(self, robot: str, vertex: int) -> Set[int]:
        """Returns all edges that were released to the robot on its way to a vertex."""
        edges: Set[int] = set()

        def arrived() -> bool:
            edges.update(self.factory.released(robot))
            return self.factory.status_of(mission) == MissionStatus.SUCCEEDED
        mission = self.send(vertex, robot=robot)
        wait_until(arrived, 30.0, f'{robot} at {vertex}')
        return edges


if __name__ == '__main__':
    rospy.init_node('page_acts_test', disable_signals=True)
    run_cases(__file__)
