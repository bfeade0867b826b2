#!/usr/bin/env python3
"""Jobs under a ROS master: programs send them by ARCL and REST, and simulated AGVs drive them."""
from __future__ import annotations

import base64
import http.client
import json
import os
import unittest
from typing import Any, List

import rospy

from itrci_nav_msgs.msg import FleetRobot, FleetState, MissionStatus
from system_support import Recorder, kill_node, run_cases, wait_until
from warehouse import PASSWORD, PATIENCE, connected

PORT = int(os.environ.get('LD90_ARCL_PORT', '17171'))
REST_PORT = int(os.environ.get('LD90_OUTGOING_PORT', '17179'))


class RestProgram:
    """A program that sends jobs by REST."""

    def ask(self, method: str, path: str, record: Any = None) -> http.client.HTTPResponse:
        connection = http.client.HTTPConnection('127.0.0.1', REST_PORT, timeout=PATIENCE)
        login = base64.b64encode(b'toolkitadmin:' + PASSWORD).decode()
        connection.request(method, path, json.dumps(record) if record else None,
                           {'Authorization': f'Basic {login}'})
        return connection.getresponse()


class JobsTest(unittest.TestCase):
    """All tests use the same fleet; each test has its own jobs."""

    @classmethod
    def setUpClass(cls) -> None:
        rospy.init_node('jobs_test')
        cls.statuses = Recorder('/mission_status', MissionStatus)
        Recorder('/fleet_state', FleetState).wait_for(
            lambda state: all(robot.state == FleetRobot.IDLE for robot in state.robots), 60,
            'all robots')
        wait_until(lambda: cls.has_goals(), 60, 'the goals')

    @staticmethod
    def has_goals() -> bool:
        program = connected(PORT)
        program.say('getGoals')
        found = program.until('Goal')[0] == 'Goal:'
        program.close()
        return found

    def test_a_pickup_and_its_drop_off_are_driven_in_order(self) -> None:
        program, other = connected(PORT), connected(PORT)
        program.say('queuePickupDropoff 18 39 default default one')
        reply = program.until('successfully queued')
        self.assertEqual((reply[0], reply[15]), ('queuepickupdropoff', 'one'))
        for listener in (program, other):
            for words in ((reply[11], 'Pending'), (reply[11], 'Driving'), (reply[11], 'Completed'),
                          (reply[13], 'Driving'), (reply[13], 'Completed')):
                line = listener.until('QueueUpdate: ', *words)
                self.assertEqual((15, 'one'), (len(line), line[2]))
        program.close()
        other.close()

    def test_a_job_outlives_the_server_and_the_fleet_manager_and_is_done_once(self) -> None:
        program = connected(PORT)
        program.say('queuePickupDropoff 6 52 default default two')
        program.until('two', 'Driving')
        before = len(self.missions())
        for node in ('/job_server', '/path_supervisor'):
            kill_node(node)
        program.close()
        again = connected(PORT)
        again.say('queueQuery jobId two')
        again.until('two', 'PICKUP')

        def is_done() -> bool:
            again.say('queueQuery jobId two')
            states = [again.until('QueueQuery: ')[4] for _ in range(2)]
            return states == ['Completed', 'Completed']
        wait_until(is_done, PATIENCE, 'the end of the job')
        self.assertEqual(before, len(self.missions()))
        again.close()

    def test_a_job_is_cancelled_on_its_way(self) -> None:
        program = connected(PORT)
        program.say('queuePickup 52 10 three')
        program.until('three', 'Driving')
        program.say('queueCancel jobId three default tooLate')
        program.until('queuecancel cancelling "jobId" "three" "" "tooLate" from queue')
        program.until('QueueUpdate: ', 'three', 'Cancelled tooLate')
        program.close()

    def test_goals_of_a_job_change_while_its_robot_drives(self) -> None:
        program = connected(PORT)  # after the other tests no robot is near vertex 27
        program.say('queuePickupDropoff 27 18 default default four')
        pickup = program.until('successfully queued')[11]
        program.until(pickup, 'Driving')
        program.say(f'queueModify {pickup} goal 6')
        program.until(f'queuemodify modifying id {pickup} goal "6"')
        for words in ('InterruptedByModify None Goal "27"', 'InProgress Driving Goal "6"',
                      'Completed None Goal "6"', 'Completed None Goal "18"'):
            program.until('QueueUpdate: ', 'four', words)
        self.statuses.wait_for(  # the last segment may end before its mission ends
            lambda status: (status.state == MissionStatus.SUCCEEDED
                            and list(status.destinations) == [6, 18]),
            PATIENCE, 'the mission to 6 and 18')
        program.close()

    def test_a_job_of_rest_is_watched_by_stream_and_seen_in_arcl(self) -> None:
        program, rest = connected(PORT), RestProgram()
        stream = rest.ask('GET', '/Job/Stream')
        self.assertEqual(200, stream.status)
        stream.readline()  # the stream has begun
        answer = rest.ask('POST', '/JobRequest', {
            'namekey': 'own', 'jobId': 'six', 'defaultPriority': True,
            'details': [{'pickupGoal': '18', 'dropoffGoal': '39', 'priority': 10}]})
        self.assertEqual(201, answer.status)
        for words in (('PICKUP', 'Pending'), ('PICKUP', 'Driving'), ('DROPOFF', 'Completed')):
            program.until('QueueUpdate: ', 'six', *words)
        statuses: List[str] = []
        while 'Completed' not in statuses:
            line = stream.readline()
            self.assertTrue(line, statuses)
            job = json.loads(line[5:]) if line.startswith(b'data:') else {}
            if job.get('jobId') == 'six':
                statuses.append(job['status'])
        self.assertEqual(['Pending', 'InProgress', 'Completed'], sorted(set(statuses),
                                                                       key=statuses.index))
        found = json.load(rest.ask('GET', '/JobRequest/ByKey/own'))
        self.assertEqual(('Completed', 'six'), (found['status'], found['assignedJobId']))
        stream.close()
        program.close()

    def test_the_steps_at_the_goals_of_a_job_are_told_before_and_after(self) -> None:
        program = connected(PORT)
        program.say('queuePickupDropoff 10 24 default default seven')
        reply = program.until('successfully queued')
        waits = {reply[11]: 'None', reply[13]: f'ID_{reply[11]}'}
        for segment, kind in ((reply[11], 'Pickup'), (reply[13], 'Dropoff')):
            served = ['UnAllocated', 'Allocated', 'Driving', f'Before{kind}', f'After{kind}']
            course = [] if kind == 'Pickup' else [f'Pending {waits[segment]}']
            while course[-1:] != ['Completed None']:
                line = program.until('QueueUpdate: ', 'seven')
                if line[1] == segment:
                    course.append(' '.join(line[4:6]))
            self.assertEqual([f'Pending {waits[segment]}', *(f'InProgress {one}' for one in served),
                              'Completed None'], course)
        program.close()

    def test_a_swap_is_served_by_the_robot_that_brings_its_load(self) -> None:
        program = connected(PORT)
        program.say('queuePickupDropoff 18 26 default default eight')
        dropoff = program.until('successfully queued')[13]
        robot = program.until('QueueUpdate: ', dropoff, 'Allocated')[8]
        program.say('queuePickupDropoff 26 14 default default nine')
        reply = program.until('successfully queued')
        self.assertEqual('and linked to job_id eight', ' '.join(reply[18:]))
        lines: List[List[str]] = []
        while not lines or lines[-1][1] != reply[13] or lines[-1][4] != 'Completed':
            lines.append(program.until('QueueUpdate: '))
        self.assertEqual({robot}, {line[8] for line in lines if line[2] == 'nine'})
        self.assertEqual([dropoff, reply[11], reply[13]],
                         [line[1] for line in lines if line[4] == 'Completed'])
        program.close()

    def test_a_wrong_goal_makes_no_mission(self) -> None:
        program, before = connected(PORT), len(self.missions())
        program.say('queuePickup nowhere')
        program.until('CommandError: queuePickup nowhere')
        program.until('CommandErrorDescription: queuePickup no such goal "nowhere"')
        self.assertEqual(before, len(self.missions()))
        program.close()

    def missions(self) -> List[int]:
        return sorted({status.request_id for status in self.statuses.messages})


if __name__ == '__main__':
    run_cases(__file__)
