#!/usr/bin/env python3
r"""Logs in to a robot and drives it to a goal, or lists its goals. Needs no ROS.

    PYTHONPATH=src/omron_arcl/src:src/browser_guard/src \
        examples/drive_without_ros.py 127.0.0.1 12 < password_file

Start a simulated robot for it: rosrun omron_ld90_sim ld90_sim --map maps/lab.map --password adept
Ctrl-C stops the robot. Exit status 0: the robot has arrived, or the goals are listed; 1: no
connection, or the drive failed.
"""
from __future__ import annotations

import argparse
import sys

from omron_arcl import Client, Outcome, parse_line, printable, quote, replies


def main() -> int:
    """Returns 0 when the robot has arrived or its goals are listed, otherwise 1."""
    parser = argparse.ArgumentParser(description='Drives an LD-90 to a goal. The ARCL password is '
                                                 'read from standard input.')
    parser.add_argument('robot', help='host name or IP address of the robot')
    parser.add_argument('goal', nargs='?',
                        help="name of the goal; without it, the robot's goals are listed")
    parser.add_argument('--port', type=int, default=7171,
                        help="port of the robot's ARCL server (default 7171)")
    arguments = parser.parse_args()
    password = sys.stdin.buffer.readline().strip()

    with Client(arguments.robot, arguments.port, password) as robot:
        link = robot.wait_connected(timeout=10.0)
        if not link.connected:
            print(f'No connection to {link.peer}: {link.reason}.', file=sys.stderr)
            return 1
        # The list of goals shows the client how the robot encodes names that are not ASCII.
        answer = robot.execute('getGoals').wait()
        if arguments.goal is None:
            goals = [reply.name for reply in map(parse_line, answer.lines)
                     if isinstance(reply, replies.Goal)]
            print('\n'.join(map(printable, goals)))
            return 0
        drive = robot.execute(f'goto {quote(arguments.goal)}',
                              on_line=lambda line: print(printable(line)))
        try:
            result = drive.wait()
        except KeyboardInterrupt:
            robot.cancel(drive)
            result = drive.wait(timeout=10.0)
        if result is None:
            print('The robot has not confirmed within 10 s that it stopped: look where it is.',
                  file=sys.stderr)
            return 1
        print(f'{result.outcome.value}: {printable(result.words)}')
        return 0 if result.outcome is Outcome.SUCCEEDED else 1


if __name__ == '__main__':
    sys.exit(main())
