#!/usr/bin/env python3
"""Logs in at a robot, lists its goals, and drives to one of them. No ROS needed.

    PYTHONPATH=src/omron_arcl/src examples/drive_without_ros.py 127.0.0.1 12 < password_file

Try it with a simulated robot: rosrun omron_ld90_sim ld90_sim --map maps/lab.map --password adept
Ctrl-C stops the robot.
"""
from __future__ import annotations

import argparse
import sys

from omron_arcl import Client, Outcome, parse_line, printable, quote, replies


def main() -> int:
    """Returns 0 when the robot has arrived."""
    parser = argparse.ArgumentParser(description='Drives an LD-90 to a goal. The ARCL password is '
                                                 'read from standard input.')
    parser.add_argument('robot', help='name or address of the robot')
    parser.add_argument('goal', nargs='?', help='where to drive; without it, goals are listed')
    parser.add_argument('--port', type=int, default=7171, help='port of its ARCL server')
    arguments = parser.parse_args()
    password = sys.stdin.buffer.readline().strip()

    with Client(arguments.robot, arguments.port, password) as robot:
        link = robot.wait_connected(timeout=10.0)
        if not link.connected:
            print(f'No connection to {link.peer}: {link.reason}.', file=sys.stderr)
            return 1
        # Once it has listed its goals, names that are not ASCII can be sent as it writes them.
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
            print('The robot did not say that it has stopped.', file=sys.stderr)
            return 1
        print(f'{result.outcome.value}: {printable(result.words)}')
        return 0 if result.outcome is Outcome.SUCCEEDED else 1


if __name__ == '__main__':
    sys.exit(main())
