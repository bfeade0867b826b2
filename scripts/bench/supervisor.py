#!/usr/bin/env python3
"""Measures the fleet's supervisor: the delay that it adds to a mission, and its CPU and memory.

Everything runs as users run it: nodes under a ROS master, simulated robots, missions by topic, the
journal on this computer's disk. `--only SECTION` runs one part (see SECTIONS). `headline` takes
nine minutes, each other part less than three.
"""
from __future__ import annotations

import socket
import sqlite3
import statistics
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, Callable, Dict, Iterator, List, Sequence, Tuple

import rospy
from arcl_tap import ArclTap
from measuring.processes import cpu_seconds, descendants, node_name, proportional
from measuring.sections import print_sections
from measuring.tables import Row
from measuring.timing import p50_and_p99
from supervisor_bench.stacks import AGVS, MANAGER, ROBOT, ROBOT_WITH_STEPS, Stack

from fleet_core.files.fleet_file import load_fleet
from itrci_nav_msgs.msg import (
    EdgeState,
    ExecutionRouteStates,
    FleetState,
    MissionCommand,
    MissionRequest,
    MissionStatus,
    StepCommand,
    StepParameter,
    StepState,
    StepStates,
    TargetRoute,
)
from ports import free_port
from system_support import Recorder, connected_publisher, wait_until

ROOT = Path(__file__).resolve().parents[2]
LAB = {'graph': ROOT / 'maps/lab_graph.yaml', 'fleet': ROOT / 'maps/lab_fleet.yaml'}
MISSION = (18, 39, 52, 6, 16)
ROBOT_NAME = 'omron_ld90'
RUNS = 5
# speed of the simulated LD-90's clock; on this clock, our delays are SPEED times as long
SPEED = 4.0
DRIVES = 20
STEPS = 100
ACCEPTED = 300
AGV_COUNT = 50
FLOODED_AGVS = 10
LOAD_SECONDS = 60.0


class Robot:
    """One simulated LD-90 behind the real nodes, and its reports."""

    def __init__(self, stack: Stack, speed: float, text: str = ROBOT) -> None:
        ports = {name: free_port() for name in ('robot', 'tap', 'outgoing')}
        self.tap = ArclTap(ports['tap'], ports['robot'])
        stack.launch(text, speed=speed, **ports)
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        self.reports = Recorder(f'/{ROBOT_NAME}/execution_route_states', ExecutionRouteStates)
        self.reports.wait_for(lambda report: report.symbolic_pose.edge_id, 90, 'robot on the graph')

    def drive(self, begin: Callable[[], Any], ends: Callable[[ExecutionRouteStates], bool]
              ) -> Tuple[float, Tuple[int, ...]]:
        """Returns the seconds from `begin` to the last report, and the edges that were driven."""
        heard, begun = len(self.reports.messages), time.monotonic()
        before = self.reports.messages[-1] if heard else ExecutionRouteStates()
        begin()
        last = self.reports.wait_for(ends, 200, 'end of the drive', heard)
        seconds = time.monotonic() - begun
        # An order omits edges that are already driven, but the route record counts all of them.
        driven = {number: edge for report in self.reports.messages[heard:]
                  if report.epoch == last.epoch for number, edge in driven_edges(report)}
        if before.epoch == last.epoch:
            for number, _ in driven_edges(before):
                driven.pop(number, None)
        return seconds, tuple(driven[number] for number in sorted(driven))


def driven_edges(report: ExecutionRouteStates) -> Iterator[Tuple[int, int]]:
    """Yields the COMPLETE edges of a report, with their numbers in the route record."""
    for number, edge in enumerate(report.edge_states, report.first):
        if edge.state == EdgeState.COMPLETE:
            yield number, edge.edge_id


class Missions:
    """Sends missions to the fleet manager, and receives their states."""

    def __init__(self, robots: int) -> None:
        self.statuses = Recorder('/mission_status', MissionStatus)
        self.requests = connected_publisher('/mission_request', MissionRequest,
                                            to='path_supervisor')
        Recorder('/fleet_state', FleetState).wait_for(
            lambda state: sum(robot.seen != rospy.Time(0) for robot in state.robots) == robots,
            90, 'all robots')
        wait_until(self.statuses.is_connected, 30, 'connection to /mission_status')
        self.last = 0

    def send(self, *vertices: int) -> int:
        """Sends one mission; returns its id."""
        self.last += 1
        self.requests.publish(request_id=self.last, destination_vertices_id=vertices)
        return self.last

    def wait(self, id: int, *states: int) -> None:
        """Waits until a mission is in one of these states."""
        self.statuses.wait_for(lambda status: status.request_id == id and status.state in states,
                               200, f'mission {id} in {states}')


def has_ended(route: int, report: ExecutionRouteStates) -> bool:
    """Returns whether the report is about this route, and the route is complete."""
    return bool(report.route_id == route) and is_complete(report)


def is_done(key: int, message: StepStates) -> bool:
    """Returns whether the step with this key is done."""
    return any((one.key, one.state) == (key, StepState.DONE) for one in message.steps)


def is_complete(report: ExecutionRouteStates) -> bool:
    """Returns whether the whole route is driven and the robot is docked."""
    return bool(report.edge_states) and report.edge_states[-1].edge_id == 13 and all(
        edge.state == EdgeState.COMPLETE for edge in report.edge_states)


def headline() -> Iterator[Row]:
    """Measures the dissertation's mission with the fleet manager; for the floor, the benchmark
    sends the same edges in one order.
    """
    with Stack() as stack:
        robot = Robot(stack, SPEED)
        manager = stack.launch(MANAGER, speed=SPEED, **LAB)
        missions = Missions(1)
        runs = []
        for _ in range(RUNS):
            runs.append(robot.drive(lambda: missions.send(*MISSION), is_complete))
            missions.wait(missions.last, MissionStatus.SUCCEEDED)
        stack.end(manager)
        edges = runs[0][1]
        by_hand = connected_publisher(f'/{ROBOT_NAME}/target_route', TargetRoute)
        floors = [robot.drive(partial(by_hand.publish, route_id=1000 + id, edges=edges),
                              partial(has_ended, 1000 + id)) for id in range(RUNS)]
    seconds, floor = (statistics.median(run[0] for run in found) * SPEED
                      for found in (runs, floors))
    yield Row(f'mission {" ".join(map(str, MISSION))} from the dock, {len(edges)} edges; the robot '
              f'drives {SPEED:.0f} times as fast, so each delay of ours counts {SPEED:.0f} times',
              f'{seconds:.1f} s of the robot: {100 * (seconds / floor - 1):+.1f} %',
              f'{floor:.1f} s, the same edges sent by hand at once', '< 2 %')


def latency() -> Iterator[Row]:
    """Measures the time from /mission_request to the first byte of the robot's first motion
    command.
    """
    with Stack() as stack:
        robot = Robot(stack, SPEED)
        stack.launch(MANAGER, speed=SPEED, **LAB)
        missions = Missions(1)
        found = []
        for run in range(DRIVES + 2):
            begun = time.monotonic()
            id = missions.send(20 if run % 2 else 18)
            missions.wait(id, MissionStatus.SUCCEEDED)
            first = min(moment for moment in robot.tap.motions if moment > begun)
            found.append(1e3 * (first - begun))
    found = sorted(found[2:])  # the planner prepares itself during the first two missions
    yield Row('`/mission_request` to the first byte of a motion command, one LD-90',
              f'p50 {statistics.median(found):.0f} ms, at most {found[-1]:.0f} ms of {len(found)}',
              '', 'p50 < 60 ms')


def step() -> Iterator[Row]:
    """Measures the time from a step command to the first byte of an LD-90's command.

    The floor is a bare node that sends one byte for each step command.
    """
    with Stack() as stack:
        robot = Robot(stack, 1.0, ROBOT_WITH_STEPS)
        floor = bare_steps()
        states = Recorder(f'/{ROBOT_NAME}/step_states', StepStates)
        commands = connected_publisher(f'/{ROBOT_NAME}/step_command', StepCommand,
                                       to='step_runner')
        run = states.wait_for(lambda _: True, 60, 'the steps of the robot').run
        found = []
        for key in range(1, STEPS + 3):
            begun = time.monotonic()
            commands.publish(key=key, act=StepCommand.DO, known_run=run, timeout=20.0,
                             type='setOutput' if key % 2 else 'clearOutput',
                             parameters=[StepParameter('output', 'Output_1')])
            states.wait_for(partial(is_done, key), 20, f'step {key} done')
            found.append(1e3 * (min(one for one in robot.tap.outputs if one > begun) - begun))
    yield Row(f'from `step_command` to the first byte of the robot\'s command, one LD-90, '
              f'{STEPS} steps',
              p50_and_p99(found[2:]), f'{p50_and_p99(floor)}: a bare hop to a byte', 'p50 < 15 ms')


def bare_steps() -> List[float]:
    """Returns the times (ms) from a command to the byte that a bare node sends for it."""
    with socket.create_server(('127.0.0.1', 0)) as server:
        program = Path(__file__).parent / 'supervisor_bench/bare_step.py'
        process = subprocess.Popen([sys.executable, str(program), str(server.getsockname()[1])])
        try:
            connection, _ = server.accept()
            commands = connected_publisher('/bare_step', StepCommand)
            found = []
            for key in range(STEPS + 2):
                begun = time.monotonic()
                commands.publish(key=key, type='setOutput',
                                 parameters=[StepParameter('output', 'Output_1')])
                connection.recv(1)
                found.append(1e3 * (time.monotonic() - begun))
            return found[2:]
        finally:
            process.terminate()
            process.wait(20)


def acceptance() -> Iterator[Row]:
    """Measures the time from a request to its first status; the floor is a commit on the same disk.
    """
    with Stack() as stack:
        stack.launch(MANAGER, speed=1.0, **LAB)
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        missions = Missions(0)
        commands = connected_publisher('/mission_command', MissionCommand, to='path_supervisor')
        found = []
        for _ in range(ACCEPTED):
            begun = time.monotonic()
            id = missions.send(18)
            missions.wait(id, MissionStatus.PENDING)
            found.append(1e3 * (time.monotonic() - begun))
            commands.publish(request_id=id, command=MissionCommand.CANCEL)
            missions.wait(id, MissionStatus.CANCELLED)
        floor = bare_commits(stack.folder)
    yield Row(f'mission sent to its status heard, on the disk before ({ACCEPTED} missions)',
              p50_and_p99(found), f'{p50_and_p99(floor)}: a bare SQLite commit', 'p99 < 30 ms')


def bare_commits(folder: Path) -> List[float]:
    """Returns the times (ms) to commit one small row, as safely as the journal."""
    database = sqlite3.connect(folder / 'bare.sqlite', isolation_level=None)
    database.execute('PRAGMA journal_mode=WAL')
    database.execute('PRAGMA synchronous=FULL')
    database.execute('CREATE TABLE row (text TEXT)')
    found = []
    for _ in range(ACCEPTED):
        begun = time.monotonic()
        database.execute('INSERT INTO row VALUES (?)', ('x' * 200,))
        found.append(1e3 * (time.monotonic() - begun))
    return found


def load() -> Iterator[Row]:
    """Measures CPU and memory of the three nodes while fifty AGVs drive random missions."""
    with Stack() as stack:
        files = stack.agv_fleet(AGV_COUNT)
        manager = stack.launch(MANAGER, speed=1.0, **files)
        stack.launch(AGVS, **files)
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        reports = [Recorder(f'/agv_{k}/execution_route_states', ExecutionRouteStates)
                   for k in range(1, AGV_COUNT + 1)]
        fleet = Recorder('/fleet_state', FleetState)
        fleet.wait_for(lambda state: sum(robot.has_mission for robot in state.robots)
                       >= 0.9 * AGV_COUNT, 120, 'a busy fleet')
        time.sleep(20.0)  # in this time the first plans for all robots are made
        before = {pid: cpu_seconds(pid) for pid in descendants(manager.pid) if node_name(pid)}
        heard = sum(len(recorder.messages) for recorder in reports)
        begun = time.monotonic()
        time.sleep(LOAD_SECONDS)
        seconds = time.monotonic() - begun
        rate = (sum(len(recorder.messages) for recorder in reports) - heard) / seconds
        shares: Dict[str, float] = {}
        memory: Dict[str, float] = {}
        for pid, used in before.items():
            shares[node_name(pid)] = 100 * (cpu_seconds(pid) - used) / seconds
            memory[node_name(pid)] = proportional(pid) / 2 ** 20
        busy = sum(robot.has_mission for robot in fleet.messages[-1].robots)
    each = ', '.join(f'{name} {share:.0f} %, {memory[name]:.0f} MB'
                     for name, share in sorted(shares.items()))
    yield Row(f'supervisor, planner and server with {AGV_COUNT} AGVs, {busy} of them on missions, '
              f'{rate:.0f} reports a second',
              f'{sum(shares.values()):.0f} % of a core, {sum(memory.values()):.0f} MB ({each})', '',
              '< 50 %, 200 MB')


def flood(count: int) -> Iterator[Row]:
    """Measures answers to `count` simultaneous requests, and to a cancel among them, while a fleet
    drives.
    """
    with Stack() as stack:
        files = stack.agv_fleet(FLOODED_AGVS)
        stack.launch(MANAGER, speed=1.0, **files)
        stack.launch(AGVS, **files)
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        fleet = Recorder('/fleet_state', FleetState)
        fleet.wait_for(lambda state: sum(robot.has_mission for robot in state.robots)
                       >= 0.9 * FLOODED_AGVS, 120, 'a busy fleet')
        flooding = Flooding(count, [robot.vertex for robot in load_fleet(files['fleet']).robots])
        heard = len(fleet.messages)
        seconds, cancel = flooding.run()
        time.sleep(5.0)
        states = fleet.messages[heard:]
    age = max((state.header.stamp - robot.seen).to_sec()
              for state in states for robot in state.robots)
    gap = max((later.header.stamp - state.header.stamp).to_sec()
              for state, later in zip(states, states[1:]))
    yield Row(f'{count} requests at once, {FLOODED_AGVS} AGVs that drive, a cancel in their midst',
              f'all answered after {seconds:.1f} s, the cancel after {cancel:.2f} s; oldest report '
              f'{age:.2f} s, longest time between two `/fleet_state` {gap:.2f} s', '',
              'reports and cancel < 2 s; answers < 60 s')


class Flooding:
    """Simultaneous requests, each for one of the vertices, and the messages about them."""

    def __init__(self, count: int, vertices: Sequence[int]) -> None:
        self._count, self._vertices = count, vertices
        self._answered: Dict[int, float] = {}  # by mission id: when the first status came
        self._cancelled = 0.0
        rospy.Subscriber('/mission_status', MissionStatus, self._hear)
        self._requests, self._commands = (
            rospy.Publisher(topic, kind, queue_size=count + 10)
            for topic, kind in (('/mission_request', MissionRequest),
                                ('/mission_command', MissionCommand)))
        wait_until(lambda: self._requests.get_num_connections()
                   and self._commands.get_num_connections(), 30, 'connections')

    def _hear(self, status: MissionStatus) -> None:
        self._answered.setdefault(status.request_id, time.monotonic())
        if status.request_id == 1 and status.state == MissionStatus.CANCELLED:
            self._cancelled = time.monotonic()

    def _send(self, id: int) -> None:
        self._requests.publish(request_id=id, destination_vertices_id=[
            self._vertices[id % len(self._vertices)]])

    def run(self) -> Tuple[float, float]:
        """Returns the seconds until all requests are answered, and until an earlier mission is
        cancelled.
        """
        self._send(1)
        wait_until(lambda: 1 in self._answered, 30, 'the first mission')
        begun = asked = time.monotonic()
        for id in range(2, self._count + 2):
            self._send(id)
            if id == self._count // 2:
                asked = time.monotonic()
                self._commands.publish(request_id=1, command=MissionCommand.CANCEL)
        ids = range(1, self._count + 2)
        wait_until(lambda: self._cancelled and all(id in self._answered for id in ids), 300,
                   'all answers, and the cancel')
        return max(self._answered[id] for id in ids) - begun, self._cancelled - asked


SECTIONS: Dict[str, Callable[[], Iterator[Row]]] = {
    'headline': headline, 'latency': latency, 'step': step, 'acceptance': acceptance, 'load': load,
    'flood_2000': lambda: flood(2000), 'flood_5000': lambda: flood(5000)}


if __name__ == '__main__':
    print_sections(SECTIONS, __doc__)
