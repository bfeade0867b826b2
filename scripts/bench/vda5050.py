#!/usr/bin/env python3
"""Measures VDA 5050: latencies through the adapter, many vehicles on one broker, and driving.

The floor is bare MQTT. The benchmark starts its own mosquitto on loopback. The stack runs with a
simulated LD-90. A tap in the ARCL connection notes when the first command of an order passes.
"""
from __future__ import annotations

import argparse
import json
import signal
import statistics
import subprocess
import tempfile
import threading
import time
import uuid
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

import rospy
from arcl_tap import ArclTap
from measuring.processes import cpu_seconds, descendants, node_name
from measuring.ros_master import own_ros_master
from measuring.tables import print_row, print_table
from measuring.timing import p50_and_p99
from std_msgs.msg import Bool

from ports import free_port
from trajectory_graph import Graph, load_graph
from vda5050_bench.layout import track_on
from vda5050_bench.master import BenchMaster
from vda5050_bench.track import Track
from vda5050_mqtt.link import Broker, MqttLink, make_client
from vda5050_mqtt.own_broker import OwnBroker

ROOT = Path(__file__).resolve().parents[2]
PREFIX = 'uagv/v2/OMRON/omron_ld90'
DOCK = 16
MISSION = (DOCK, 18, 39, 52, 6, DOCK)
RUNS = 5
CHANGES = 200
ORDERS = 15
VEHICLES, RATE, SECONDS = 50, 2.0, 20.0
AHEAD = 8.0  # m; the base ends at least this far ahead of the vehicle


@contextmanager
def stack(broker: Broker, sim_speed: float, folder: Path) -> Iterator[Tuple[ArclTap, int]]:
    """Starts the stack under a separate ROS master; yields the tap and the id of roslaunch."""
    robot_port, outgoing = free_port(), free_port()
    tap = ArclTap(free_port(), robot_port)
    launch, vehicle = folder / 'bench.launch', folder / 'vehicle.yaml'
    vehicle.write_text((ROOT / 'src/vda5050_vehicle/config/ld90/vehicle.yaml').read_text()
                       + '  field_violation: {topic: bench, type: std_msgs/Bool, field: data}\n')
    launch.write_text(f'''<launch>
  <include file="{ROOT}/launch/sim.launch">
    <arg name="arcl_port" value="{robot_port}"/><arg name="outgoing_port" value="{outgoing}"/>
    <arg name="sim_speed" value="{sim_speed}"/>
  </include>
  <include file="{ROOT}/launch/robot.launch">
    <arg name="arcl_port" value="{tap.port}"/><arg name="outgoing_port" value="{outgoing}"/>
    <arg name="password_file" value="$(find omron_ld90_sim)/config/simulator_password"/>
    <arg name="map_file" value="{ROOT}/maps/lab.map"/>
    <arg name="graph_file" value="{ROOT}/maps/lab_graph.yaml"/>
    <arg name="dock_vertex" value="{DOCK}"/>
  </include>
  <group ns="omron_ld90">
    <node name="robot_state_publisher" pkg="omron_ld90" type="robot_state_publisher"/>
  </group>
  <include file="{ROOT}/launch/vda5050.launch">
    <arg name="broker" value="{broker.host}:{broker.port}"/>
    <arg name="graph_file" value="{ROOT}/maps/lab_graph.yaml"/>
    <arg name="vehicle_file" value="{vehicle}"/>
    <arg name="journal" value="{folder}/journal_{uuid.uuid4().hex}.json"/>
  </include>
</launch>''')
    with own_ros_master():
        process = subprocess.Popen(['roslaunch', str(launch)], stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL)
        try:
            yield tap, process.pid
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(30)


def milliseconds(values: Sequence[float]) -> str:
    """Returns times (s) as a text in ms for a table."""
    return p50_and_p99([1e3 * value for value in values])


def ready(master: BenchMaster) -> None:
    """Waits until the vehicle is at the dock, without errors."""
    master.wait(lambda s: s['lastNodeId'] and not s['errors'], 60, 'a vehicle that is well')


def bare_mqtt(broker: Broker, payload: bytes) -> List[float]:
    """Returns the floor: the times (s) that `payload` takes from one client to another."""
    arrived: List[float] = []
    event = threading.Event()
    clients = [make_client(f'bare_{uuid.uuid4().hex[:8]}') for _ in range(2)]

    def on_message(*_: object) -> None:
        arrived.append(time.monotonic())
        event.set()

    clients[1].on_message = on_message
    for client in clients:
        client.connect(broker.host, broker.port)
        client.loop_start()
    clients[1].subscribe('bare')
    time.sleep(0.5)  # not all paho versions can tell when a subscription is in force
    latencies = []
    for _ in range(CHANGES):
        event.clear()
        begun = time.monotonic()
        clients[0].publish('bare', payload)
        event.wait(2.0)
        latencies.append(arrived[-1] - begun)
        time.sleep(0.01)
    for client in clients:
        client.loop_stop()
        client.disconnect()
    return latencies


def ros_to_mqtt(master: BenchMaster) -> List[float]:
    """Returns the times (s) from a change of the field violation in ROS to the state at an MQTT
    subscriber.
    """
    publisher = rospy.Publisher('/omron_ld90/bench', Bool, queue_size=1, tcp_nodelay=True)
    deadline = time.monotonic() + 30.0
    while not any(info[1].endswith('vda5050_vehicle')
                  for info in publisher.impl.get_stats_info()):
        if time.monotonic() > deadline:
            raise SystemExit('the adapter does not subscribe to its signal')
        time.sleep(0.05)
    latencies = []
    for number in range(CHANGES):
        pressed = number % 2 == 0
        heard = master.count()
        begun = time.monotonic()
        publisher.publish(pressed)
        master.wait(partial(is_violated, pressed), 5.0, 'the change', after=heard)
        latencies.append(first_with(master, heard, pressed) - begun)
        time.sleep(0.02)
    publisher.unregister()
    return latencies


def is_violated(wanted: bool, state: Dict[str, Any]) -> bool:
    """Returns whether the field violation in a state is `wanted`."""
    return bool(state['safetyState']['fieldViolation'] == wanted)


def first_with(master: BenchMaster, heard: int, pressed: bool) -> float:
    """Returns when the first state came whose field violation is `pressed`."""
    for state, moment in zip(master.messages['state'][heard:], master.arrivals['state'][heard:]):
        if state['safetyState']['fieldViolation'] == pressed:
            return moment
    raise SystemExit('the state with the change did not arrive')


def drive(master: BenchMaster, track: Track, send: Callable[[str], int]) -> float:
    """Returns the seconds from an order to its end; `send` sends the order."""
    order_id = uuid.uuid4().hex[:8]
    begun = time.monotonic()
    heard = send(order_id)
    master.wait(lambda s: s['orderId'] == order_id and not s['nodeStates'] and not s['driving'],
                400.0, 'the end of the order', after=heard)
    return time.monotonic() - begun


def whole(master: BenchMaster, track: Track) -> Callable[[str], int]:
    """Returns a function that sends the order in one message."""
    return lambda order_id: master.send('order', track.order(order_id))


def by_single_edges(master: BenchMaster, track: Track, lengths: Sequence[float],
                    ) -> Callable[[str], int]:
    """Returns a function that sends the order edge by edge, with a base of at least `AHEAD` m."""
    def send(order_id: str) -> int:
        base, update = 1, 0
        heard = master.send('order', track.part(0, 1).order(order_id))
        while base < len(track.edges):
            state = master.state
            if state['orderId'] == order_id:
                passed = state['lastNodeSequenceId'] // 2
                ahead = sum(lengths[passed:base]) - state.get('distanceSinceLastNode', 0.0)
                if ahead < AHEAD + max(lengths) and base - passed < 40:
                    update += 1
                    master.send('order', track.part(base, base + 1).order(
                        order_id, update, first_sequence=2 * base))
                    base += 1
                    continue
            time.sleep(0.02)
        return heard
    return send


def order_to_arcl(master: BenchMaster, tap: ArclTap, graph: Graph) -> List[float]:
    """Returns the times from an order to the first byte of its command on the ARCL connection."""
    latencies = []
    there = track_on(graph, (8, 10), 'map')
    for track in (there, there.reversed()) * (ORDERS // 2 + 1):
        passed = len(tap.motions)
        begun = time.monotonic()
        drive(master, track, whole(master, track))
        latencies.append(tap.motions[passed] - begun)
    return latencies[:ORDERS]


def many_vehicles(broker: Broker, payload: Dict[str, object]) -> Tuple[int, int, List[float]]:
    """Runs many vehicles on one broker. Returns the messages sent, the messages received, and the
    latencies of the states.
    """
    arrived: List[float] = []
    subscriber = make_client('many')
    subscriber.on_message = lambda _c, _u, message: arrived.append(
        time.monotonic() - json.loads(message.payload)['sent'])
    subscriber.connect(broker.host, broker.port)
    subscriber.subscribe('uagv/v2/+/+/state')
    subscriber.loop_start()
    links = [MqttLink(broker, f'uagv/v2/bench/{n}', f'bench_{n}', lambda state: b'{}',
                      lambda *_: None, lambda *_: None) for n in range(VEHICLES)]
    for link in links:
        link.start()
    while not all(link.connected for link in links):
        time.sleep(0.05)
    sent, begun = 0, time.monotonic()
    while time.monotonic() - begun < SECONDS:
        due = begun + sent / (VEHICLES * RATE)
        time.sleep(max(due - time.monotonic(), 0.0))
        message = json.dumps({**payload, 'sent': time.monotonic()}).encode()
        links[sent % VEHICLES].publish('state', message)
        sent += 1
    time.sleep(1.0)
    received = list(arrived)
    for link in links:
        link.close()
    subscriber.loop_stop()
    subscriber.disconnect()
    return sent, len(received), received


def returns(master: BenchMaster, own_broker: OwnBroker) -> List[float]:
    """Returns the times (s) from the broker's return to the state ONLINE."""
    found = []
    for _ in range(RUNS):
        heard = master.count('connection')
        own_broker.kill()
        time.sleep(2.0)
        own_broker.start()
        begun = time.monotonic()
        master.wait(lambda m: m['connectionState'] == 'ONLINE', 20.0, 'ONLINE', 'connection',
                    heard)
        found.append(time.monotonic() - begun)
    return found


def share_of_core(pid: int, seconds: float) -> float:
    """Returns the CPU use of the adapter, as a share of one core."""
    adapter = next(child for child in descendants(pid)
                   if node_name(child) == 'vda5050_vehicle')
    before = cpu_seconds(adapter)
    time.sleep(seconds)
    return (cpu_seconds(adapter) - before) / seconds


def part_latency(broker: Broker, own_broker: OwnBroker, folder: Path) -> None:
    """Shows the rows for a robot in real time: latencies, CPU, many vehicles, and the return of the
    broker.
    """
    graph = load_graph(ROOT / 'maps' / 'lab_graph.yaml')
    master = BenchMaster(broker, PREFIX)
    with stack(broker, 1.0, folder) as (_, pid):
        rospy.init_node('vda5050_bench', anonymous=True, disable_signals=True)
        ready(master)
        changes = ros_to_mqtt(master)
        bare = bare_mqtt(broker, json.dumps(master.state).encode())
        row('ROS change to MQTT subscriber, p50, p99', milliseconds(changes), milliseconds(bare),
            'p50 < 1.5 ms, p99 < 10 ms')
        way = track_on(graph, (DOCK, 35), 'map')
        master.send('order', way.order('cpu'))
        master.wait(lambda s: s['driving'], 20.0, 'driving')
        row('adapter while driving, share of a core', f'{100 * share_of_core(pid, 15.0):.1f} %',
            '', '< 3 %')
        back = returns(master, own_broker)
        row(f'back after the broker, median and longest of {RUNS}',
            f'{statistics.median(back):.1f} s, {max(back):.1f} s', '', '< 3 s')
    master.close()
    state = json.dumps(master.state)
    payload: Dict[str, object] = {'filling': state + 'x' * max(3000 - len(state), 0)}
    sent, received, latencies = many_vehicles(broker, payload)
    row(f'{VEHICLES} vehicles at {RATE:g} Hz, 3 kB: lost of {sent}; p50, p99',
        f'{sent - received}; {milliseconds(latencies)}', milliseconds(bare),
        'none, p99 < 20 ms')


def part_mission(broker: Broker, folder: Path) -> None:
    """Shows the rows: time from an order to the ARCL connection, and the mission of the laboratory
    in one message and edge by edge.
    """
    graph = load_graph(ROOT / 'maps' / 'lab_graph.yaml')
    track = track_on(graph, MISSION, 'map')
    lengths = [graph.curve(int(edge)).length for edge in track.edges]
    master = BenchMaster(broker, PREFIX)
    speed = 4.0
    times: Dict[str, List[float]] = {'whole': [], 'single': []}
    with stack(broker, speed, folder) as (tap, _):
        ready(master)
        way = track_on(graph, (DOCK, 8), 'map')
        drive(master, way, whole(master, way))
        first = order_to_arcl(master, tap, graph)
        row('order to first ARCL byte, p50, p99', milliseconds(first), '', 'p50 < 10 ms')
        drive(master, way, whole(master, way.reversed()))
        for _ in range(2):
            times['whole'].append(speed * drive(master, track, whole(master, track)))
            times['single'].append(speed * drive(master, track,
                                                 by_single_edges(master, track, lengths)))
    master.close()
    base, single = (statistics.median(times[name]) for name in ('whole', 'single'))
    row(f'mission of {len(track.edges)} edges by single-edge updates, base kept {AHEAD:g} m ahead '
        '(robot\'s seconds)', f'{single:.1f} s', f'{base:.1f} s, one order',
        f'within 3 %: {100 * (single / base - 1):+.1f} %')


def row(figure: str, value: str, floor: str, goal: str) -> None:
    """Prints a line of the table."""
    print_row((figure, value, floor, goal))


def main() -> None:
    """Prints the table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument('--only', choices=('latency', 'mission'), help='a part of it')
    only = options.parse_args().only
    port = free_port()
    own_broker = OwnBroker(port)
    print_table([], ('figure', 'measured', 'floor: bare MQTT', 'goal'))
    with tempfile.TemporaryDirectory() as folder:
        try:
            if only != 'mission':
                part_latency(Broker('127.0.0.1', port), own_broker, Path(folder))
            if only != 'latency':
                part_mission(Broker('127.0.0.1', port), Path(folder))
        finally:
            own_broker.close()


if __name__ == '__main__':
    main()
