#!/usr/bin/env python3
"""A warehouse program: sends one job to job_server, or to OMRON's Fleet Manager, and follows it.

    examples/warehouse_program.py PASSWORD_FILE PICKUP_GOAL DROPOFF_GOAL JOB_ID [HOST [PORT]]

It ends with status 0 when the robot has delivered. If you start it again with the same job id while
the job is active, it follows the job and queues no second one. It needs nothing but Python.
"""
import socket
import sys

FINAL = ('Completed', 'Cancelled', 'Failed')


def main(password_file, pickup, dropoff, job, host='127.0.0.1', port='7171'):
    """Sends the job and follows it; returns the exit status."""
    with open(password_file, encoding='utf-8') as file:
        password = file.read().strip()
    with socket.create_connection((host, int(port))) as connection:
        lines = connection.makefile('r', encoding='utf-8', newline='\r\n')

        def say(line):
            connection.sendall(line.encode() + b'\r\n')

        def words_until(end):
            """Yields the words of each line, until a line begins with the word `end`."""
            for line in lines:
                words = line.split()
                if words and words[0] == end:
                    return
                yield words
            sys.exit('the connection has ended')

        say(password)
        for _ in words_until('End'):  # End of commands
            pass
        # Was the job queued by an earlier run of this program?
        say(f'queueQuery jobId {job}')
        states = {words[1]: words[4] for words in words_until('EndQueueQuery')
                  if words[:1] == ['QueueQuery:']}
        if any(state not in FINAL for state in states.values()):
            print(f'{job} is active already')
        else:
            states = {}
            say(f'queuePickupDropoff {pickup} {dropoff} default default {job}')
        for words in words_until('CommandErrorDescription:'):
            if words[:1] == ['queuepickupdropoff']:
                states = {words[11]: 'Pending', words[13]: 'Pending'}
                print(' '.join(words))
            elif words[:1] == ['QueueUpdate:'] and words[2] == job:
                segment, status, substatus, robot = words[1], words[4], words[5], words[8]
                states[segment] = status
                print(segment, status, substatus, robot, flush=True)
                if all(state in FINAL for state in states.values()):
                    return int(set(states.values()) != {'Completed'})
    return 2  # the job was refused


if __name__ == '__main__':
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
