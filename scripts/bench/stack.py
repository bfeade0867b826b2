"""Measures the whole stack: seconds from `scripts/run.sh` to the first pose, and the CPU when idle.

The floor of the start is roslaunch with one bare rospy publisher. The floor of the CPU is a bare
publisher at the stack's own rate, 2 Hz.
"""
from __future__ import annotations

import multiprocessing
import os
import signal
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Callable, Dict, List, Tuple

from measuring.processes import cpu_seconds, descendants, node_name
from measuring.tables import Row, print_table

from ports import free_port

ROOT = Path(__file__).resolve().parents[2]
RUNS = 5
IDLE_SECONDS = 20.0
BARE = '''<launch>
  <node name="bare" pkg="rostopic" type="rostopic" args="pub -r 2 /tf tf2_msgs/TFMessage {}"/>
</launch>'''


def first_transform(master_port: int, result: multiprocessing.Queue) -> None:
    """Puts into `result` the time at which the first message on /tf arrives."""
    import rosgraph
    import rospy
    from tf2_msgs.msg import TFMessage
    os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{master_port}'
    while not rosgraph.Master('/bench').is_online():
        time.sleep(0.005)
    rospy.init_node('bench', anonymous=True, disable_signals=True)
    rospy.wait_for_message('/tf', TFMessage)
    result.put(time.monotonic())


def run(command: Callable[[int], List[str]], idle: bool) -> Tuple[float, Dict[str, float]]:
    """Starts a command. Returns the seconds to the first transform and, if `idle`, the CPU share of
    each idle node.
    """
    master_port = free_port()
    queue: multiprocessing.Queue = multiprocessing.get_context('spawn').Queue()
    watcher = multiprocessing.get_context('spawn').Process(
        target=first_transform, args=(master_port, queue), daemon=True)
    watcher.start()
    environment = {**os.environ, 'ROS_MASTER_URI': f'http://127.0.0.1:{master_port}'}
    time.sleep(1.0)  # the time in which the watcher imports its modules must not be measured
    begun = time.monotonic()
    process = subprocess.Popen(command(master_port), env=environment, stdout=subprocess.DEVNULL,
                               stderr=subprocess.DEVNULL)
    try:
        seconds = queue.get(timeout=120) - begun
        shares: Dict[str, float] = {}
        if idle:
            time.sleep(5.0)  # after this time the start-up is over
            before = {pid: cpu_seconds(pid) for pid in descendants(process.pid)
                      if node_name(pid) not in ('', 'rosout')}
            time.sleep(IDLE_SECONDS)
            shares = {node_name(pid): (cpu_seconds(pid) - used) / IDLE_SECONDS
                      for pid, used in before.items()}
        return seconds, shares
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(30)
        watcher.terminate()


def stack(_: int) -> List[str]:
    """Starts the stack with the user's command, on free ports."""
    return [str(ROOT / 'scripts/run.sh'), 'rviz:=false', f'arcl_port:={free_port()}',
            f'outgoing_port:={free_port()}']


def main() -> None:
    """Prints the tables."""
    with tempfile.NamedTemporaryFile('w', suffix='.launch') as bare:
        bare.write(BARE)
        bare.flush()

        def floor(port: int) -> List[str]:
            return ['roslaunch', '-p', str(port), bare.name]

        starts = [run(stack, idle=False)[0] for _ in range(RUNS)]
        floors = [run(floor, idle=False)[0] for _ in range(RUNS)]
        shares = run(stack, idle=True)[1]
        bare_share = sum(run(floor, idle=True)[1].values())
    print_table([
        Row('`scripts/run.sh` (nothing missing) to the first TF',
            f'{statistics.median(starts):.2f} s', f'{statistics.median(floors):.2f} s', '< 7 s'),
        Row('idle stack without RViz and roscore, 2 Hz status and laser',
            f'{100 * sum(shares.values()):.1f} % of a core', f'{100 * bare_share:.1f} %',
            '< 1.8 %')], ('figure', 'median', 'floor (one bare rospy publisher)', 'goal'))
    print()
    print_table([(f'`{name}`', f'{100 * share:.1f}')
                 for name, share in sorted(shares.items(), key=lambda item: -item[1])],
                ('node, idle', '% of a core'))


if __name__ == '__main__':
    main()
