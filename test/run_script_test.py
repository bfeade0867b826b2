#!/usr/bin/env python3
"""`scripts/run.sh` while a fleet runs, and with the password in its environment.

roslaunch writes its whole environment into its log, so the script passes the password in a file.
"""
from __future__ import annotations

import os
import signal
import stat
import subprocess
import tempfile
import unittest
from pathlib import Path

import rospy
from file_modes import differences, walk
from fleet_support import free_fleet_ports
from rosnode import rosnode_ping

from omron_ld90_msgs.msg import LinkState
from omron_ld90_sim import Simulator
from system_support import Recorder, run_cases, wait_until

ROOT = Path(__file__).resolve().parents[1]
PASSWORD = 'Cormorant-7'
#: A node with the name of a fleet manager. For the ROS master, it is another run's fleet manager.
RUNNING = "import rospy; rospy.init_node('path_supervisor'); rospy.spin()"


class RunScript(unittest.TestCase):

    def setUp(self) -> None:
        rospy.init_node('run_script')
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.home = Path(self.folder.name) / 'ros_home'
        self.home.mkdir(mode=0o700)
        self.logs = self.home / 'log'
        self.output = (Path(self.folder.name) / 'output').open('w+')
        self.addCleanup(self.output.close)

    def test_a_password_in_the_environment_reaches_the_robot_and_no_log(self) -> None:
        """The start ends with the line that says what is ready, and Ctrl-C prints nothing."""
        with Simulator(ROOT / 'maps' / 'lab.map', password=PASSWORD) as robot:
            script = self.start(
                'sim:=false', 'rviz:=false', 'robot_ip:=127.0.0.1', f'arcl_port:={robot.port}',
                f'outgoing_port:={os.environ["LD90_OUTGOING_PORT"]}')
            try:
                Recorder('/omron_ld90/link_state', LinkState).wait_for(
                    lambda m: (m.link, m.state) == (LinkState.COMMANDS, LinkState.CONNECTED),
                    60, 'connected link to the robot')
                file = Path(rospy.get_param('/omron_ld90/omron_controller/password_file'))
                self.assertEqual(stat.S_IMODE(file.stat().st_mode), 0o600)
                wait_until(lambda: 'Ready: ' in self.told(), 60, 'the last line of the start')
            finally:
                script.send_signal(signal.SIGINT)
                script.wait(30)

        wait_until(lambda: not file.exists(), 10, f'the end of {file}')
        self.assertNotIn(PASSWORD, self.told())
        # After a slow start there are two more lines: the link is up; no outgoing connection came.
        lines = [line for line in self.told().splitlines()
                 if not line.startswith(('[INFO]', '[WARN]'))]
        for line, pattern in zip(lines[-3:], (
                '^== Starting: ', '^[0-9]+ nodes start under the ROS master at http://',
                '^Ready: omron_ld90. Click a goal in RViz, or ')):
            self.assertRegex(line, pattern, self.told())
        logs = [log for log in self.logs.rglob('*.log') if log.is_file()]
        self.assertTrue(any('roslaunch' in log.name for log in logs), logs)
        self.assertEqual([log.name for log in logs
                          if PASSWORD in log.read_text(errors='replace')], [])
        names = {os.geteuid(): 'user', os.getegid(): 'user'}
        self.assertTrue(list(self.home.rglob('*_motion.json')), list(self.home.rglob('*')))
        self.assertEqual(differences(walk(self.home, 'ROS_HOME', names)), [])

    def test_a_fleet_does_not_take_the_nodes_of_one_that_runs(self) -> None:
        """Under one ROS master two fleets would end and restart each other's nodes for ever."""
        running = subprocess.Popen(['/usr/bin/python3', '-c', RUNNING])
        try:
            wait_until(lambda: rosnode_ping('/path_supervisor', max_count=1), 30,
                       'a running fleet manager')
            first = free_fleet_ports()
            script = self.start('fleet:=1', 'rviz:=false', 'page:=false', f'control_port:={first}',
                                f'arcl_port:={first + 2}', f'outgoing_port:={first + 3}')
            try:
                self.assertEqual(script.wait(60), 1)
            finally:
                script.send_signal(signal.SIGINT)
                script.wait(30)
            self.assertIn('/path_supervisor runs under this ROS master already', self.told())
            self.assertIsNone(running.poll())
        finally:
            running.terminate()
            running.wait(10)

    def told(self) -> str:
        """Returns the output of the script so far."""
        return Path(self.output.name).read_text()

    def start(self, *args: str) -> subprocess.Popen:
        return subprocess.Popen(
            [str(ROOT / 'scripts' / 'run.sh'), *args], stdout=self.output,
            stderr=subprocess.STDOUT, env={**os.environ, 'OMRON_LD90_PASSWORD': PASSWORD,
                                           'ROS_HOME': str(self.home),
                                           'ROS_LOG_DIR': str(self.logs)})


if __name__ == '__main__':
    run_cases(__file__)
