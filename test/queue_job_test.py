#!/usr/bin/env python3
"""job_client hands a job to a simulated Fleet Manager, although the link is cut and the node is
killed.
"""
from __future__ import annotations

import contextlib
import os
import socket
import threading
import unittest
from typing import List

import actionlib
import rospy

from omron_ld90_msgs.msg import JobStatus, JobStop, QueueJobAction, QueueJobGoal
from system_support import Recorder, kill_node, run_cases

MANAGER = int(os.environ.get('LD90_ARCL_PORT', '17171'))
LINK = int(os.environ.get('LD90_OUTGOING_PORT', '17179'))
PATIENCE = 60.0


class CuttableLink:
    """A proxy on loopback that notes the commands for jobs. It can cut the link after such a
    command.
    """

    def __init__(self) -> None:
        self.queued: List[str] = []
        self.cuts = 0           # number of further commands after which the link is cut
        self._server = socket.create_server(('127.0.0.1', LINK))
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self) -> None:
        while True:
            client, _ = self._server.accept()
            try:
                manager = socket.create_connection(('127.0.0.1', MANAGER))
            except OSError:     # the simulator has not started yet; the node will try again
                client.close()
                continue
            for source, sink in ((client, manager), (manager, client)):
                threading.Thread(target=self._pass_on, args=(source, sink, source is client),
                                 daemon=True).start()

    def _pass_on(self, source: socket.socket, sink: socket.socket, is_client: bool) -> None:
        try:
            for line in source.makefile('rb'):
                is_job = is_client and line.lower().startswith((b'queuepickup', b'queuemulti'))
                if is_job:
                    self.queued.append(line.decode().split()[-1])
                if is_job and self.cuts:
                    self.cuts -= 1
                    source.shutdown(socket.SHUT_RDWR)   # the node never reads the answer
                    sink.sendall(line)
                    sink.shutdown(socket.SHUT_WR)
                    return
                sink.sendall(line)
        except OSError:
            pass  # one of the two connections has ended, so the other one must end, too
        for end in (source, sink):
            with contextlib.suppress(OSError):  # it may have ended already
                end.shutdown(socket.SHUT_RDWR)


class QueueJobTest(unittest.TestCase):
    """A job is driven only once, although its answer was lost and the node was killed."""

    def test_a_job_is_driven_once_over_a_cut_link_and_a_killed_node(self) -> None:
        rospy.init_node('queue_job_test')
        statuses = Recorder('/job_client/job_status', JobStatus)
        link = CuttableLink()
        link.cuts = 1
        client = actionlib.SimpleActionClient('/job_client/queue_job', QueueJobAction)
        self.assertTrue(client.wait_for_server(rospy.Duration(PATIENCE)))
        wanted = QueueJobGoal(request_id='pallet 7', stops=[
            JobStop(goal='18', kind=JobStop.PICKUP), JobStop(goal='20', kind=JobStop.DROPOFF)])
        client.send_goal(wanted)
        statuses.wait_for(lambda one: one.state == JobStatus.IN_PROGRESS, PATIENCE, 'a drive')
        kill_node('/job_client')
        before = len(statuses.messages)
        statuses.wait_for(lambda one: one.request_id == 'pallet 7', PATIENCE, 'the restart', before)
        again = actionlib.SimpleActionClient('/job_client/queue_job', QueueJobAction)
        self.assertTrue(again.wait_for_server(rospy.Duration(PATIENCE)))
        again.send_goal(wanted)     # the same request, for the same job
        self.assertTrue(again.wait_for_result(rospy.Duration(PATIENCE)), 'the job does not end')
        status = again.get_result().status
        self.assertEqual(status.state, JobStatus.COMPLETED)
        self.assertEqual(status.segment_states, ['Completed', 'Completed'])
        self.assertEqual((link.cuts, link.queued), (0, [status.job_id]))


if __name__ == '__main__':
    run_cases(__file__)
