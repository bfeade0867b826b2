"""Measures ARCL: parsing of lines, latency from the socket to a subscriber, CPU of the two nodes.

Beside each figure is its floor from the same run. The benchmark plays the robot: it sends 10
statuses and 10 scans of 1,000 points each second. The floor of latency and CPU is a bare rospy
publisher of the same lines. A bare relay publishes the lines of a socket without parsing them. The
relay shows how much of the latency comes from a further process that must wake up.
"""
from __future__ import annotations

import random
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Callable, Dict, Iterator, List, Sequence, Tuple

import numpy as np
from measuring.processes import cpu_seconds
from measuring.ros_master import own_ros_master
from measuring.tables import Row, print_table
from measuring.timing import milliseconds

from omron_arcl.session import Session
from ports import free_port

ROOT = Path(__file__).resolve().parents[2]
NODES = ROOT / 'src/omron_ld90/nodes'
RUNS = 7
SECONDS = 20.0
RATE = 10.0  # statuses per second, and scans per second
PASSWORD = b'bench'

# A bare node: it publishes the lines of a status and of a scan as plain Strings, and adds to each
# burst the time at which it was sent.
BARE_NODE = '''
import sys, time
import rospy
from std_msgs.msg import String
rospy.init_node('bare')
topics = ['state', 'extended', 'charge', 'location', 'score', 'temperature', 'scan']
lines = open(sys.argv[1]).read().splitlines()
publishers = [rospy.Publisher('/bare/' + topic, String, queue_size=10, tcp_nodelay=True)
              for topic in topics]
rate = rospy.Rate(10)
while not rospy.is_shutdown():
    now = time.monotonic_ns()
    for publisher, line in zip(publishers, lines):
        publisher.publish(line.replace('STAMP', '%019d' % now))
    rate.sleep()
'''


# A bare relay: it publishes each line of a socket as a plain String.
BARE_RELAY = '''
import socket, sys
import rospy
from std_msgs.msg import String
server = socket.create_server(('127.0.0.1', int(sys.argv[1])))
rospy.init_node('relay')
words = ['Status', 'ExtendedStatusForHumans', 'StateOfCharge', 'Location', 'LocalizationScore',
         'Temperature', 'RangeDeviceGetCurrent']
publishers = {word: rospy.Publisher('/relay/' + word, String, queue_size=10, tcp_nodelay=True)
              for word in words}
connection = server.accept()[0]
for line in connection.makefile():
    publishers[line.split(':', 1)[0]].publish(line)
'''


def lines_per_second(work: Callable[[], object], lines: int) -> float:
    """Returns the number of lines per second: the median of several runs."""
    return 1e3 * lines / milliseconds(work, RUNS)


def in_chunks(data: bytes) -> List[bytes]:
    """Cuts the bytes into chunks, like a socket."""
    return [data[i:i + 65536] for i in range(0, len(data), 65536)]


def statuses() -> Row:
    """Measures a session that parses status lines; the floor only splits and decodes the lines."""
    draw = random.Random(1)
    blocks = [f'ExtendedStatusForHumans: Going to {i}\r\nStatus: Going to {i}\r\n'
              f'StateOfCharge: {draw.uniform(0, 100):.1f}\r\n'
              f'Location: {draw.randint(-99999, 99999)} {draw.randint(-99999, 99999)} '
              f'{draw.randint(-180, 180)}\r\nLocalizationScore: {draw.random():.6f}\r\n'
              f'Temperature: {draw.randint(20, 40)}\r\n' for i in range(20_000)]
    return throughput('status lines', ''.join(blocks).encode(), 6 * len(blocks), '400,000/s')


def scans() -> Row:
    """Measures a session that parses scans of 455 points; the floor only splits and decodes."""
    points = np.random.default_rng(1).integers(-20_000, 20_000, 910)
    line = f'RangeDeviceGetCurrent: Laser_1 {" ".join(map(str, points))}\r\n'
    return throughput('scans of 455 points', line.encode() * 5000, 5000, '10,000/s')


def throughput(what: str, data: bytes, lines: int, aim: str) -> Row:
    """Measures how many lines per second the session and the replies handle."""
    chunks = in_chunks(data)

    def parse() -> None:
        session = Session(None)
        events = sum(len(session.receive(chunk)) for chunk in chunks)
        assert events == lines, events

    def split() -> None:
        for line in data.split(b'\r\n'):
            line.decode()
    ours, floor = lines_per_second(parse, lines), lines_per_second(split, lines)
    return Row(f'{what} through session and replies', f'{ours:,.0f}/s',
               f'split and decoded: {floor:,.0f}/s', aim)


def burst(stamp: int, points: str) -> Tuple[List[str], str]:
    """Returns the lines of a status and of a scan; `stamp` is the time stamp in their text."""
    mark = f'{stamp:019d}' if stamp else 'STAMP'
    status = [f'Status: Going to {mark}', f'ExtendedStatusForHumans: {mark}',
              'StateOfCharge: 79.4', 'Location: 3120 -540 -87', 'LocalizationScore: 0.870543',
              'Temperature: 36']
    return status, f'RangeDeviceGetCurrent: {mark if not stamp else "Laser_1"} {points}'


class Robot:
    """A robot: it answers the controller's login and heartbeats, and connects to the receiver."""

    def __init__(self) -> None:
        self._server = socket.create_server(('127.0.0.1', 0))
        self.port: int = self._server.getsockname()[1]
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        connection, _ = self._server.accept()
        with connection, connection.makefile('rb') as reader:
            connection.sendall(b'Enter password:\r\n')
            reader.readline()
            connection.sendall(b'Welcome to the server.\r\nCommands:\r\nEnd of commands\r\n')
            for line in reader:
                if line.strip() == b'oneLineStatus':
                    connection.sendall(b'Status: Stopped StateOfCharge: 79.4 Location: 1 2 3 '
                                       b'Temperature: 36\r\n')
                elif line.strip() == b'getGoals':
                    connection.sendall(b'Goal: 1\r\nEnd of goals\r\n')


def nodes() -> List[Row]:
    """Measures latency and CPU of the nodes and of the bare publisher."""
    import rospy
    receiver_port, relay_port = free_port(), free_port()
    points = ' '.join(map(str, np.random.default_rng(2).integers(-15_000, 15_000, 2000)))
    robot = Robot()
    processes: Dict[str, subprocess.Popen] = {}
    with own_ros_master(), tempfile.TemporaryDirectory() as folder:
        password = Path(folder) / 'password'
        password.write_bytes(PASSWORD)
        lines = Path(folder) / 'lines'
        status, scan = burst(0, points)
        lines.write_text('\n'.join([*status, scan]))
        try:
            rospy.init_node('bench', anonymous=True, disable_signals=True)
            commands = {
                'bare': ['-c', BARE_NODE, str(lines)],
                'relay': ['-c', BARE_RELAY, str(relay_port)],
                'receiver': [str(NODES / 'omron_connection_receiver'), '_robot_ip:=127.0.0.1',
                             f'_port:={receiver_port}'],
                'controller': [str(NODES / 'omron_controller'), '_robot_ip:=127.0.0.1',
                               f'_port:={robot.port}', f'_password_file:={password}']}
            for name, command in commands.items():
                processes[name] = subprocess.Popen(
                    [sys.executable, *command], stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL)
            return measure(processes, receiver_port, relay_port, points)
        finally:
            for process in reversed(list(processes.values())):
                process.terminate()
                try:
                    process.wait(10)
                except subprocess.TimeoutExpired:  # rospy can hang at its end
                    process.kill()


def measure(processes: Dict[str, subprocess.Popen], port: int, relay_port: int,
            points: str) -> List[Row]:
    """Sends lines to the receiver for a while, and measures latency and CPU."""
    import rospy
    from sensor_msgs.msg import PointCloud2
    from std_msgs.msg import String

    from omron_ld90_msgs.msg import RobotStatus
    latencies: Dict[str, List[float]] = {
        f'{sender}{what}': [] for sender in ('ours', 'bare', 'relay') for what in ('', ' scan')}
    sent = [0]

    def heard(message: String, name: str) -> None:
        stamp = int(message.data.split(' ', 4)[-1 if 'scan' not in name else 1])
        latencies[name].append((time.monotonic_ns() - stamp) / 1e6)

    def scan_heard(_message: object, name: str) -> None:
        latencies[name].append((time.monotonic_ns() - sent[0]) / 1e6)
    rospy.Subscriber('status/state', String, heard, 'ours', tcp_nodelay=True)
    rospy.Subscriber('/bare/state', String, heard, 'bare', tcp_nodelay=True)
    rospy.Subscriber('/relay/Status', String, heard, 'relay', tcp_nodelay=True)
    rospy.Subscriber('laser_points', String, scan_heard, 'ours scan', tcp_nodelay=True)
    rospy.Subscriber('/relay/RangeDeviceGetCurrent', String, scan_heard, 'relay scan',
                     tcp_nodelay=True)
    rospy.Subscriber('/bare/scan', String, heard, 'bare scan', tcp_nodelay=True)
    for topic, kind in (('robot_status', RobotStatus), ('laser_cloud', PointCloud2),
                        ('status/location', String), ('/bare/location', String)):
        rospy.Subscriber(topic, kind, lambda _: None, tcp_nodelay=True)
    connections = [connect(port), connect(relay_port)]
    deadline = time.monotonic() + 30.0
    while not all(latencies.values()):
        feed(connections, points, sent, 1)
        if time.monotonic() > deadline:
            raise RuntimeError(f'nothing came: {latencies}')
    for values in latencies.values():
        values.clear()
    before = {name: cpu_seconds(process.pid) for name, process in processes.items()}
    begin = time.monotonic()
    feed(connections, points, sent, int(SECONDS * RATE))
    elapsed = time.monotonic() - begin
    share = {name: 100.0 * (cpu_seconds(process.pid) - before[name]) / elapsed
             for name, process in processes.items()}
    for connection in connections:
        connection.close()
    together = share['controller'] + share['receiver']
    return [
        latency_row('status line (6 lines at 10 Hz)', latencies, '', aim=1.15),
        latency_row('scan of 1,000 points at 10 Hz', latencies, ' scan', aim=1.3),
        Row('CPU of controller + receiver, 10 Hz status and 1,000-point scans',
            f'{together:.1f} % of a core ({share["controller"]:.1f} + {share["receiver"]:.1f})',
            f'bare publisher of the same lines: {share["bare"]:.1f} %', 'under 6 %')]


def latency_row(what: str, latencies: Dict[str, List[float]], of: str, aim: float) -> Row:
    """Returns one row: p50 and p99 of the nodes, of the floor, and of the bare relay.

    aim -- largest p50 of the nodes, as a multiple of the floor's p50
    """
    (p50, p99), (bare50, bare99), (relay50, relay99) = (
        np.percentile(latencies[f'{sender}{of}'], (50, 99)) for sender in ('ours', 'bare', 'relay'))
    return Row(f'socket to subscriber: {what}',
               f'p50 {p50:.2f} ms ({p50 / bare50:.2f} x; {p50 / relay50:.2f} x the relay), '
               f'p99 {p99:.2f} ms',
               f'bare rospy hop: p50 {bare50:.2f} ms, p99 {bare99:.2f} ms; '
               f'bare relay: p50 {relay50:.2f} ms, p99 {relay99:.2f} ms',
               f'p50 within {aim} x, p99 under 5 ms')


def connect(port: int) -> socket.socket:
    """Opens the robot's outgoing connection."""
    deadline = time.monotonic() + 30.0
    while True:
        try:
            connection = socket.create_connection(('127.0.0.1', port))
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            return connection
        except ConnectionRefusedError:
            if time.monotonic() > deadline:
                raise
            time.sleep(0.05)


def feed(connections: Sequence[socket.socket], points: str, sent: List[int], times: int) -> None:
    """Sends statuses and scans to each connection in turn, at equal intervals."""
    pause = 0.5 / RATE / len(connections)
    due = time.monotonic()
    for _ in range(times):
        for connection in connections:
            status, scan = burst(time.monotonic_ns(), points)
            connection.sendall('\r\n'.join([*status, '']).encode())
            due += pause
            time.sleep(max(due - time.monotonic(), 0.0))
            data = f'{scan}\r\n'.encode()
            sent[0] = time.monotonic_ns()
            connection.sendall(data)
            due += pause
            time.sleep(max(due - time.monotonic(), 0.0))


def main() -> None:
    """Measures everything and prints the table."""
    def rows() -> Iterator[Row]:
        yield statuses()
        yield scans()
        yield from nodes()
    print_table(rows())


if __name__ == '__main__':
    main()
