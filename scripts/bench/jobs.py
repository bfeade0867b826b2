#!/usr/bin/env python3
"""Measures job_server: the delay that it adds to a job, and its CPU time with many clients.

Everything runs as users run it: nodes under a ROS master, simulated robots, jobs over TCP, files on
this computer's disk. `--only SECTION` runs one part (see SECTIONS). Each part takes two to four
minutes.
"""
from __future__ import annotations

import statistics
import threading
import time
from typing import Callable, Dict, Iterator, List

import rospy
from measuring.processes import cpu_seconds, descendants, node_name, proportional
from measuring.sections import print_sections
from measuring.tables import Row
from supervisor import LAB, SPEED, Missions, Robot
from supervisor_bench.stacks import MANAGER, Stack

from fleet_core.files.fleet_file import load_fleet
from itrci_nav_msgs.msg import MissionStatus
from ports import free_port
from warehouse import Warehouse, connected

DRIVES = 20
CLIENTS = 20
JOBS = 1000
AGV_COUNT = 10
POLL = 0.5          # s between two queueShowRobot commands of a client, as in real programs
LOAD_SECONDS = 30.0
SERVER = '''<launch>
  <include file="$(find omron_jobs)/launch/job_server.launch">
    <arg name="password_file" value="$(find omron_ld90_sim)/config/simulator_password"/>
    <arg name="port" value="{port}"/> <arg name="jobs_file" value="{folder}/jobs.sqlite"/>
  </include>
</launch>'''
AGVS = '''<launch>
  <node name="agvs" pkg="graph_fleet_manager" type="agv_sim">
    <param name="graph_file" value="{graph}"/> <param name="fleet_file" value="{fleet}"/>
  </node>
</launch>'''


def latency() -> Iterator[Row]:
    """Measures the time from a job line to the first byte of the robot's first motion command."""
    with Stack() as stack:
        robot, port = Robot(stack, SPEED), free_port()
        stack.launch(MANAGER, speed=SPEED, **LAB)
        stack.launch(SERVER, port=port)
        missions, program = Missions(1), connected(port)
        found: Dict[str, List[float]] = {'job': [], 'mission': []}
        for run in range(2 * DRIVES + 2):
            kind = ('job', 'mission')[run // 2 % 2]
            goal, heard = (20 if run % 2 else 18), len(missions.statuses.messages)
            begun = time.monotonic()
            if kind == 'job':
                program.say(f'queuePickup {goal}')
            else:
                missions.send(goal)
            missions.statuses.wait_for(lambda status: status.state == MissionStatus.SUCCEEDED, 200,
                                       'the end of the drive', heard)
            first = min(moment for moment in robot.tap.motions if moment > begun)
            found[kind].append(1e3 * (first - begun))
        program.close()
    jobs, floor = sorted(found['job'][2:]), sorted(found['mission'])
    yield Row('from the line of a job to the first byte of a motion command, one LD-90',
              f'p50 {statistics.median(jobs):.0f} ms, at most {jobs[-1]:.0f} ms of {len(jobs)}',
              f'p50 {statistics.median(floor):.0f} ms, at most {floor[-1]:.0f} ms of {len(floor)}: '
              'from `/mission_request`', 'p50 < 20 ms')


class Polling:
    """Clients that ask for the robots repeatedly, and read all answers."""

    def __init__(self, port: int) -> None:
        self.lines, self._ends = 0, False
        self._clients = [connected(port) for _ in range(CLIENTS)]
        self._threads = [threading.Thread(target=act, args=(client,), daemon=True)
                         for client in self._clients for act in (self._read, self._ask)]
        for thread in self._threads:
            thread.start()

    def _read(self, client: Warehouse) -> None:
        for _ in client.lines():
            self.lines += 1

    def _ask(self, client: Warehouse) -> None:
        while not self._ends:
            client.say('queueShowRobot')
            time.sleep(POLL)

    def end(self) -> None:
        """Ends all clients."""
        self._ends = True
        for client in self._clients:
            client.say('quit')
        for thread in self._threads:
            thread.join(20)


def load() -> Iterator[Row]:
    """Measures CPU and memory of the node with many clients and jobs; the floor has neither."""
    with Stack() as stack:
        files, port = stack.agv_fleet(AGV_COUNT), free_port()
        stack.launch(MANAGER, speed=1.0, **files)
        stack.launch(AGVS, **files)
        server = stack.launch(SERVER, port=port)
        rospy.init_node('bench', anonymous=True, disable_signals=True)
        missions, program = Missions(AGV_COUNT), connected(port)
        pid = next(pid for pid in descendants(server.pid) if node_name(pid) == 'job_server')
        floor = share(pid)
        goals = [robot.vertex for robot in load_fleet(files['fleet']).robots]
        begun = time.monotonic()
        for k in range(JOBS):
            program.say(f'queuePickupDropoff {goals[k % AGV_COUNT]} {goals[(k + 3) % AGV_COUNT]}')
        for _ in range(JOBS):
            program.until('successfully queued')
        queueing = time.monotonic() - begun
        polling = Polling(port)
        missions.statuses.wait_for(lambda status: status.state == MissionStatus.SUCCEEDED, 200,
                                   'the first job')
        heard, begun = polling.lines, time.monotonic()
        found = share(pid)
        rate = (polling.lines - heard) / (time.monotonic() - begun)
        memory = proportional(pid) / 2 ** 20
        polling.end()
    yield Row(f'job_server with {CLIENTS} clients that poll every {POLL} s, {JOBS} active jobs, '
              f'{AGV_COUNT} AGVs that drive; {rate:.0f} lines a second to the clients',
              f'{found:.1f} % of a core, {memory:.0f} MB; the jobs were queued in {queueing:.1f} s',
              f'{floor:.1f} %: the node without clients and jobs', '< 20 % of a core')


def share(pid: int) -> float:
    """Returns the share of a core (%) that a process uses."""
    before, begun = cpu_seconds(pid), time.monotonic()
    time.sleep(LOAD_SECONDS)
    return 100 * (cpu_seconds(pid) - before) / (time.monotonic() - begun)


SECTIONS: Dict[str, Callable[[], Iterator[Row]]] = {'latency': latency, 'load': load}


if __name__ == '__main__':
    print_sections(SECTIONS, __doc__)
