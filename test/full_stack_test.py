#!/usr/bin/env python3
"""The first minutes of a user: the stack works, `goto 12` drives, the reference is complete."""
from __future__ import annotations

import math
import re
import unittest
from pathlib import Path

import rosgraph
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped

from omron_ld90_msgs.msg import LinkState
from system_support import Recorder, drive_to, run_cases, wait_until

ROOT = Path(__file__).resolve().parents[1]
ROBOT = '/omron_ld90/'
GOAL_12 = (-4.5, 0.0)  # maps/lab_graph.yaml


class FullStack(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('full_stack')
        cls.master = rosgraph.Master('/full_stack')
        cls.documents = '\n'.join(
            file.read_text(encoding='utf-8')
            for file in (ROOT / 'docs' / 'reference').glob('*.md'))
        links = Recorder(ROBOT + 'link_state', LinkState)
        for link in (LinkState.COMMANDS, LinkState.OUTGOING):
            links.wait_for(lambda m, link=link: m.link == link and m.state == LinkState.CONNECTED,
                           60, f'connected link {link}')

    def test_goto_12_drives_to_goal_12(self) -> None:
        poses = Recorder(ROBOT + 'pose', PoseStamped)
        drive_to('omron_ld90', '12')
        poses.wait_for(lambda m: math.hypot(m.pose.position.x - GOAL_12[0],
                                            m.pose.position.y - GOAL_12[1]) < 0.1,
                       10, 'pose at goal 12', after=max(0, len(poses.messages) - 1))

    def test_everything_reports_itself_healthy(self) -> None:
        diagnostics = Recorder('/diagnostics', DiagnosticArray)
        latest = {}

        def healthy() -> bool:
            for message in list(diagnostics.messages):
                latest.update((status.name, status) for status in message.status)
            nodes = {name.split(':')[0] for name in latest}
            return (len(nodes) >= 4 and
                    all(status.level == DiagnosticStatus.OK for status in latest.values()))

        try:
            wait_until(healthy, 60, 'all diagnostics OK')
        except AssertionError:
            self.fail('; '.join(f'{status.name}: level {status.level}, {status.message}'
                                for status in latest.values()))

    def test_every_topic_and_service_stands_in_the_interface_reference(self) -> None:
        publishers, subscribers, services = self.master.getSystemState()
        names = {name for name, _ in publishers + subscribers + services
                 if name.startswith(ROBOT)}
        own = {self.documented_name(name[len(ROBOT):]) for name in names
               if not name.endswith(('/get_loggers', '/set_logger_level', '/tf2_frames'))}
        unknown = sorted(name for name in own if f'`{name}`' not in self.documents)
        self.assertFalse(unknown, f'docs/reference does not know: {unknown}')

    def test_every_parameter_stands_in_the_interface_reference(self) -> None:
        nodes = {name.rsplit('/', 1)[1] for name in self.node_names()}
        unknown = []
        for name in self.master.getParamNames():
            match = re.match(ROBOT + r'([^/]+)/(.+)', name)
            if match and match.group(1) in nodes and f'`~{match.group(2)}`' not in self.documents:
                unknown.append(name)
        self.assertFalse(unknown, f'docs/reference does not know: {unknown}')

    def test_the_password_is_no_parameter_and_in_no_process_list(self) -> None:
        password = (ROOT / 'src/omron_ld90_sim/config/simulator_password').read_text().strip()
        parameters = str(rospy.get_param('/'))
        self.assertNotIn(password, parameters)
        mentions = [arguments for arguments in map(self.arguments, Path('/proc').glob('[0-9]*'))
                    if password in re.split(r'[\0 ]', arguments)]
        self.assertFalse(mentions)

    @staticmethod
    def documented_name(name: str) -> str:
        """Returns the name of a topic in the reference. There all topics of an action, or of an
        interactive marker server, are one entry.
        """
        return re.sub(r'/(goal|cancel|status|feedback|result|update|update_full)$', '', name)

    def node_names(self):
        publishers, _, _ = self.master.getSystemState()
        return {node for _, nodes in publishers for node in nodes if node.startswith(ROBOT)}

    @staticmethod
    def arguments(process: Path) -> str:
        try:
            return (process / 'cmdline').read_text(errors='replace')
        except OSError:  # the node has ended meanwhile
            return ''


if __name__ == '__main__':
    run_cases(__file__)
