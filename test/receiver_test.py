#!/usr/bin/env python3
"""The receiver publishes what the robot sent: as unchanged bytes, and as typed values in SI units.
"""
from __future__ import annotations

import math
import os
import signal
import socket
import time
import unittest
import xmlrpc.client
from pathlib import Path
from typing import Set

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import BatteryState, PointCloud2
from sensor_msgs.point_cloud2 import read_points
from std_msgs.msg import String

from omron_ld90_msgs.msg import LinkState, RobotStatus
from system_support import Recorder, run_cases, wait_until

SOON = 10.0  # s
STATUS = {  # topic -> line
    'extended_status': b'ExtendedStatusForHumans: Going to 12|slowly',
    'state': b'Status: Going to 12',
    'state_of_charge': b'StateOfCharge: 79.4',
    'location': b'Location: 3120 -540 -87',
    'localization_score': b'LocalizationScore: 0.870543',
    'temperature': b'Temperature: 36',
}


class RawString(String):
    """A String whose data remain bytes; rospy's own class decodes the data as UTF-8."""

    def deserialize(self, buffer: bytes) -> RawString:
        self.data = buffer[4:]
        return self


class ReceiverTest(unittest.TestCase):
    """The test plays the robot's outgoing connection."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.lines = {name: Recorder(f'/omron_ld90/status/{name}', RawString) for name in STATUS}
        cls.laser_points = Recorder('/omron_ld90/laser_points', RawString)
        cls.clouds = Recorder('/omron_ld90/laser_cloud', PointCloud2)
        cls.statuses = Recorder('/omron_ld90/robot_status', RobotStatus)
        cls.batteries = Recorder('/omron_ld90/battery_state', BatteryState)
        cls.links = Recorder('/omron_ld90/link_state', LinkState)
        cls.diagnostics = Recorder('/diagnostics', DiagnosticArray)
        cls.links.wait_for(lambda link: link.state == LinkState.DISCONNECTED, 30.0, 'receiver')
        cls.robot = cls.connect()
        # Subscribers connect one after the other. The tests begin when all have got a status.
        wait_until(cls.everybody_hears, 20.0, 'every subscriber gets a message of the receiver')

    @classmethod
    def connect(cls) -> socket.socket:
        return socket.create_connection(('127.0.0.1', rospy.get_param('~port')), timeout=SOON)

    @classmethod
    def everybody_hears(cls) -> bool:
        cls.send(*STATUS.values(), b'RangeDeviceGetCurrent: Laser_1 1 2')
        recorders = (*cls.lines.values(), cls.laser_points, cls.clouds, cls.statuses,
                     cls.batteries)
        return all(recorder.messages for recorder in recorders)

    @classmethod
    def send(cls, *lines: bytes) -> None:
        cls.robot.sendall(b''.join(line + b'\r\n' for line in lines))

    def setUp(self) -> None:
        type(self).robot.close()
        type(self).robot = self.connect()

    def test_every_status_line_comes_out_as_it_was_received(self):
        # ARCL is ASCII, but a goal's name can contain other bytes, which are passed on unchanged.
        lines = {**STATUS, 'state': b'Status: Going to caf\xe9 \x01'}
        before = {name: len(recorder.messages) for name, recorder in self.lines.items()}
        self.send(*lines.values())
        for name, line in lines.items():
            self.lines[name].wait_for(lambda m, line=line: m.data == line, SOON, f'line {line}',
                                      before[name])

    def test_a_status_is_typed_in_si_units(self):
        before = len(self.statuses.messages)
        start = rospy.Time.now()
        self.send(*STATUS.values())
        status = self.statuses.wait_for(lambda m: m.header.stamp >= start, SOON, 'status', before)
        self.assertAlmostEqual(0.870543, status.localization_score, places=5)
        self.assertEqual('Going to 12', status.status)
        self.assertEqual('Going to 12|slowly', status.extended_status)
        self.assertEqual('map', status.header.frame_id)
        self.assertLessEqual(status.header.stamp, rospy.Time.now())
        self.assertAlmostEqual(3.12, status.pose.position.x)
        self.assertAlmostEqual(-0.54, status.pose.position.y)
        self.assertAlmostEqual(math.sin(math.radians(-43.5)), status.pose.orientation.z)
        self.assertAlmostEqual(0.794, status.state_of_charge, places=5)
        self.assertTrue(math.isnan(status.battery_voltage))
        self.assertEqual(36.0, status.temperature)

    def test_the_battery_charges_or_not_by_the_docking_state(self):
        before = len(self.batteries.messages)
        self.send(b'DockingState: Docked ForcedState: Unforced ChargeState: Bulk',
                  *STATUS.values())
        charging = BatteryState.POWER_SUPPLY_STATUS_CHARGING
        battery = self.batteries.wait_for(lambda m: m.power_supply_status == charging, SOON,
                                          'charging battery', before)
        self.assertAlmostEqual(0.794, battery.percentage, places=5)
        self.assertTrue(math.isnan(battery.voltage))

    def test_an_emergency_stop_shows_in_the_status_and_in_diagnostics(self):
        before = len(self.statuses.messages)
        told = len(self.diagnostics.messages)

        def shown() -> bool:
            self.send(*{**STATUS, 'state': b'Status: EStop pressed'}.values())
            return any(status.level == DiagnosticStatus.ERROR and 'emergency stop' in status.message
                       for array in self.diagnostics.messages[told:] for status in array.status)
        wait_until(shown, SOON, 'emergency stop in /diagnostics')
        self.statuses.wait_for(lambda m: m.emergency_stop, SOON, 'emergency stop', before)

    def test_a_scan_becomes_a_cloud_of_its_points_in_metres(self):
        line = b'RangeDeviceGetCurrent: Laser_1 3378 -617 3446 -6175'
        before, clouds = len(self.laser_points.messages), len(self.clouds.messages)
        self.send(line)
        self.laser_points.wait_for(lambda m: m.data == line, SOON, 'the line', before)
        cloud = self.clouds.wait_for(lambda m: m.width == 2, SOON, 'the cloud', clouds)
        self.assertEqual('map', cloud.header.frame_id)
        points = [point for xyz in read_points(cloud) for point in xyz]
        for expected, found in zip((3.378, -0.617, 0.203, 3.446, -6.175, 0.203), points):
            self.assertAlmostEqual(expected, found, places=4)

    def test_silence_is_reported_and_nothing_is_published_again(self):
        before = len(self.links.messages)
        self.send(*STATUS.values())
        link = self.links.wait_for(lambda m: 'nothing was received' in m.reason, SOON, 'silence',
                                   before)
        self.assertEqual(LinkState.DISCONNECTED, link.state)
        last = self.statuses.messages[-1].header.stamp
        heard = len(self.diagnostics.messages)
        self.diagnostics.wait_for(lambda array: True, SOON, 'a second to pass', heard)
        self.assertEqual(last, self.statuses.messages[-1].header.stamp)

    def test_what_waited_while_the_receiver_stood_still_is_not_published_as_new(self):
        node = self.process_id('/omron_ld90/omron_connection_receiver')
        self.send(*{**STATUS, 'location': b'Location: 1000 0 0'}.values())
        os.kill(node, signal.SIGSTOP)
        try:
            wait_until(lambda: self.states_of(node) == {'T'}, SOON, 'every thread is stopped')
            before = len(self.statuses.messages)
            deadline = time.monotonic() + 2.5
            wait_until(lambda: self.sends_status(2000) and time.monotonic() > deadline, SOON,
                       'two and a half seconds')
        finally:
            os.kill(node, signal.SIGCONT)
        wait_until(lambda: self.sends_status(3000) and any(
            abs(m.pose.position.x - 3.0) < 0.1 for m in self.statuses.messages[before:]), SOON,
            'statuses again')
        published = {round(m.pose.position.x) for m in self.statuses.messages[before:]}
        self.assertNotIn(2, published)

    def test_a_flood_of_garbage_starves_nothing(self):
        """During ten megabytes of garbage, statuses, link and diagnostics must continue."""
        node = self.process_id('/omron_ld90/omron_connection_receiver')
        log = Recorder('/rosout', Log)
        wait_until(log.is_connected, SOON, 'rosout')
        memory = self.memory_of(node)
        statuses, links, told = (len(topic.messages) for topic in (
            self.statuses, self.links, self.diagnostics))
        garbage = b''.join(bytes(1 + (i + j) % 255 for j in range(200)) + b'\r\n'
                           for i in range(500))
        self.robot.settimeout(60.0)
        for x in range(5000, 5100):
            self.robot.sendall(garbage)
            self.sends_status(x)
        self.statuses.wait_for(lambda m: abs(m.pose.position.x - 5.099) < 1e-4, 60.0,
                               'the last status', statuses)
        self.assertEqual(100, len(self.statuses.messages) - statuses, 'statuses')
        first, last = (self.statuses.messages[i].header.stamp.to_sec() for i in (statuses, -1))
        self.links.wait_for(lambda _: True, SOON, 'the link again', links)
        self.diagnostics.wait_for(lambda _: True, SOON, 'diagnostics', told)
        repeated = [m for m in self.links.messages[links:] if m.state != LinkState.CONNECTED]
        self.assertEqual([], repeated, 'the link was connected all the time')
        self.assertLess(self.memory_of(node) - memory, 50.0, 'MB of memory')
        self.assertLess(len([m for m in log.messages if m.name.endswith('receiver')]), 20,
                        'lines in the log')
        print(f'flood: 10 MB in {last - first:.1f} s, '
              f'{self.memory_of(node) - memory:+.1f} MB of memory')

    @staticmethod
    def memory_of(process_id: int) -> float:
        """Returns the resident memory of a process, in MB."""
        pages = int(Path(f'/proc/{process_id}/statm').read_text(encoding='ascii').split()[1])
        return pages * os.sysconf('SC_PAGE_SIZE') / 1e6

    def sends_status(self, x: int) -> bool:
        self.send(*{**STATUS, 'location': f'Location: {x} 0 0'.encode()}.values())
        return True

    @staticmethod
    def states_of(process_id: int) -> Set[str]:
        """Returns the states of a process's threads; T means stopped."""
        return {file.read_text(encoding='utf-8').rsplit(')', 1)[1].split()[0]
                for file in Path(f'/proc/{process_id}/task').glob('*/stat')}

    @staticmethod
    def process_id(node: str) -> int:
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        _, _, process_id = xmlrpc.client.ServerProxy(uri).getPid(rospy.get_name())
        return process_id

    def test_what_the_robot_does_is_typed(self):
        before = len(self.statuses.messages)
        self.send(*{**STATUS, 'state': b'Status: Arrived at K\xfcche'}.values())
        status = self.statuses.wait_for(lambda m: m.activity == RobotStatus.ARRIVED_AT_GOAL, SOON,
                                        'arrival', before)
        self.assertEqual('K\xfcche', status.goal)

    def test_a_number_that_cannot_be_silences_no_topic(self):
        before = len(self.statuses.messages)
        self.send(*{**STATUS, 'state_of_charge': b'StateOfCharge: 1e41',
                    'location': b'Location: 1e308 0 0',
                    'temperature': b'Temperature: 1e39'}.values())
        wait_until(lambda: self.sends_status(4000) and any(
            abs(m.pose.position.x - 4.0) < 0.1 for m in self.statuses.messages[before:]), SOON,
            'the statuses after it')
        self.assertFalse([m for m in self.statuses.messages[before:] if m.state_of_charge > 1.0])

    def test_a_new_connection_replaces_the_old_one(self):
        old = self.robot
        type(self).robot = self.connect()
        before = len(self.statuses.messages)
        self.send(*STATUS.values())
        self.statuses.wait_for(lambda _: True, SOON, 'status on the new connection', before)
        old.settimeout(SOON)
        while True:
            try:
                if not old.recv(100):
                    break
            except ConnectionResetError:
                break
        old.close()


if __name__ == '__main__':
    rospy.init_node('receiver_test')
    run_cases(__file__)
