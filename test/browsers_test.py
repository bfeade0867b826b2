#!/usr/bin/env python3
"""ROS's own tools work as usual, and a foreign web page changes nothing in any server."""
from __future__ import annotations

import json
import os
import shutil
import socket
import subprocess
import tempfile
import threading
import unittest
import xmlrpc.client
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Iterator, List, Tuple

import rosgraph
import rospy
from rosgraph_msgs.msg import Log
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

from omron_ld90_msgs.msg import LinkState
from ports import free_port
from system_support import (
    Launched,
    Recorder,
    connected_publisher,
    drive_to,
    run_cases,
    wait_until,
)

CHROMIUM = shutil.which('chromium')
PAGE = """<!doctype html><title>a foreign page</title><script>
const calls = %s;
Promise.allSettled(calls.map(([address, body]) => fetch(address, {
  method: 'POST', mode: 'no-cors', headers: {'Content-Type': 'text/plain'}, body: body,
  signal: AbortSignal.timeout(5000)})))
  .then(() => fetch('/done', {method: 'POST'}));
</script>"""


def tool(*arguments: str) -> str:
    """Returns the output of a command of ROS."""
    return subprocess.run(arguments, check=True, timeout=60, text=True,
                          stdout=subprocess.PIPE).stdout


@contextmanager
def opened_by_a_browser(calls: List[Tuple[str, str]]) -> Iterator[None]:
    """Shows a page that sends these calls (address, body). Continues when all are answered."""
    done = threading.Event()

    class Site(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            page = (PAGE % json.dumps(calls)).encode()
            self.send_response(200)
            self.send_header('Content-Type', 'text/html')
            self.send_header('Content-Length', str(len(page)))
            self.end_headers()
            self.wfile.write(page)

        def do_POST(self) -> None:
            self.send_response(204)
            self.end_headers()
            done.set()

        def log_message(self, format: str, *args: object) -> None:  # noqa: A002  the base's name
            pass

    site = ThreadingHTTPServer(('127.0.0.1', 0), Site)
    threading.Thread(target=site.serve_forever, daemon=True).start()
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = subprocess.Popen(
            [CHROMIUM, '--headless', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage',
             '--remote-debugging-port=0', f'--user-data-dir={profile}',
             f'http://localhost:{site.server_port}/'],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            assert done.wait(60), 'the browser has not sent all requests'
            yield
        finally:
            browser.terminate()
            browser.wait(10)
            site.shutdown()
            site.server_close()


def attack(master: str) -> List[Tuple[str, str]]:
    """Returns calls that would make a ROS master begin a mission and change a parameter."""
    return [(master, xmlrpc.client.dumps(call, name)) for name, call in (
        ('registerPublisher', ('/page', '/mission_request', 'itrci_nav_msgs/MissionRequest',
                               'http://127.0.0.1:9/')),
        ('setParam', ('/page', '/set_by_a_page', 1)))]


class Browsers(unittest.TestCase):

    @classmethod
    def setUpClass(cls) -> None:
        port = free_port()  # rostest already runs a master in its own process
        cls.uri = os.environ['ROS_MASTER_URI'] = f'http://localhost:{port}'
        cls.core = subprocess.Popen(['roscore', '-p', str(port)], stdout=subprocess.DEVNULL)
        wait_until(lambda: rosgraph.is_master_online(cls.uri), 30, 'the ROS master')
        rospy.init_node('browsers')
        cls.master = rosgraph.Master('/browsers')

    @classmethod
    def tearDownClass(cls) -> None:
        cls.core.terminate()
        cls.core.wait(20)

    def test_tools_of_ros_work_as_before(self) -> None:
        tool('rosparam', 'set', '/browsers/number', '7')
        self.assertEqual(rospy.get_param('/browsers/number'), 7)
        self.assertEqual(tool('rosparam', 'get', '/browsers/number').strip(), '7')
        self.assertIn('/browsers', tool('rosnode', 'list').split())
        self.assertIn('xmlrpc reply', tool('rosnode', 'ping', '-c', '1', '/browsers'))
        self.assertIn('Pid', tool('rosnode', 'info', '/rosout'))
        service = rospy.Service('/browsers/ask', Trigger, lambda _: TriggerResponse(True, 'yes'))
        self.assertIn('yes', tool('rosservice', 'call', '/browsers/ask'))
        service.shutdown('asked')
        words = Recorder('/browsers/word', String)
        tool('rostopic', 'pub', '-1', '/browsers/word', 'std_msgs/String', 'hello')
        words.wait_for(lambda word: word.data == 'hello', 20, 'word of rostopic')
        latched = rospy.Publisher('/browsers/latched', String, queue_size=1, latch=True)
        latched.publish('kept')
        self.assertIn('kept', tool('rostopic', 'echo', '-n', '1', '/browsers/latched'))
        self.assertIn('Type: std_msgs/String', tool('rostopic', 'info', '/browsers/latched'))

    def test_a_node_in_cpp_sends_and_receives(self) -> None:
        lines = Recorder('/rosout_agg', Log)  # rosout is a node in C++
        wait_until(lines.is_connected, 20, 'connection with rosout')

        def repeated(line: Log) -> bool:
            return line.msg == 'a line for rosout'

        def told() -> bool:
            rospy.loginfo('a line for rosout')
            return any(map(repeated, lines.messages))

        wait_until(told, 20, 'line that rosout repeats')

    def test_the_master_answers_under_each_of_its_names(self) -> None:
        port = self.uri.rstrip('/').rpartition(':')[2]
        for host in ('127.0.0.1', 'localhost', socket.gethostname()):
            with xmlrpc.client.ServerProxy(f'http://127.0.0.1:{port}/', headers=[
                    ('Host', f'{host}:{port}')]) as master:
                self.assertEqual(master.getPid('/browsers')[0], 1, host)

    def test_a_node_leaves_out_a_message_that_is_too_large_and_obeys_the_next_one(self) -> None:
        with Launched('full_stack.launch', robot_name='full', rviz='false', sim_speed=10,
                      arcl_port=free_port(), outgoing_port=free_port()) as stack:
            commands = connected_publisher('/full/send_command', String)
            commands.publish('goto ' + 1_000_000 * 'x')
            stack.wait_for_line('A message on /full/send_command is left out: it has 1000009 bytes')
            drive_to('full', '12')

    @unittest.skipUnless(CHROMIUM, 'there is no chromium')
    def test_a_foreign_page_changes_nothing(self) -> None:
        with Launched('full_stack.launch', robot_name='shut', rviz='false',
                      arcl_port=free_port(), outgoing_port=free_port()):
            Recorder('/shut/link_state', LinkState).wait_for(
                lambda link: link.state == LinkState.CONNECTED, 60, 'link of the controller')
            ours = {name: self.master.lookupNode(name)
                    for name in tool('rosnode', 'list', '/shut').split()
                    if '/omron_' in name}
            self.assertIn('/shut/omron_controller', ours)
            calls = attack(self.uri) + [
                (uri, xmlrpc.client.dumps(('/page', 'for fun'), 'shutdown'))
                for uri in ours.values()]
            with opened_by_a_browser(calls):
                self.assertFalse(rospy.has_param('/set_by_a_page'))
                publishers = dict(self.master.getSystemState()[0])
                self.assertNotIn('/page', publishers.get('/mission_request', []))
                for name in ours:
                    self.assertIn('xmlrpc reply', tool('rosnode', 'ping', '-c', '1', name))

    @unittest.skipUnless(CHROMIUM, 'there is no chromium')
    def test_the_same_page_commands_a_foreign_master(self) -> None:
        """Shows that the page in the other test is a real attack."""
        own = Path(str(shutil.which('rosmaster'))).resolve()
        foreign = next(path for folder in os.environ['PATH'].split(':')
                       for path in [Path(folder, 'rosmaster').resolve()]
                       if path.exists() and path != own)
        port = free_port()
        master = subprocess.Popen([str(foreign), '--core', '-p', str(port)],
                                  stdout=subprocess.DEVNULL)
        uri = f'http://127.0.0.1:{port}'
        try:
            wait_until(lambda: rosgraph.is_master_online(uri), 20, 'the foreign master')
            with opened_by_a_browser(attack(uri)):
                self.assertTrue(rosgraph.Master('/browsers', uri).hasParam('/set_by_a_page'))
        finally:
            master.terminate()
            master.wait(10)


if __name__ == '__main__':
    run_cases(__file__)
