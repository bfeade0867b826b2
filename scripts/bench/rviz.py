"""Measures RViz in software rendering: frames per second, and the CPU of RViz and of its nodes.

The floor is RViz with the same window and frame rate, but with all displays off. Mesa's heads-up
display (GALLIUM_HUD) counts the frames and writes one number per second to a file.
"""
from __future__ import annotations

import os
import re
import signal
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Dict, List, NamedTuple

from measuring.processes import cpu_seconds, descendants, node_name
from measuring.tables import print_table
from rviz_support import Screen, missing_programs

from omron_ld90.nodes.rviz_view import rendering_arguments
from ports import free_port

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = (ROOT / 'rviz/omron_ld90.rviz').read_text()
EMPTY = re.sub(r'(?ms)^  Displays:\n.*?^  Enabled: true\n', '  Displays: ~\n  Enabled: true\n',
               SHIPPED)
SETTLE, MEASURE = 8.0, 20.0  # s
NODES = ('map_visualisation', 'robot_state_publisher', 'body_state_publisher', 'goal_sender',
         'route_visualisation')


class Figures(NamedTuple):
    """Frames per second (median), and the share of a core of each node."""

    frames: float
    shares: Dict[str, float]


def measure(screen: Screen, stack: int, configuration: str, frame_rate: int) -> Figures:
    """Runs RViz with `configuration` beside the stack, and measures both.

    stack -- process id of the stack
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'bench.rviz'
        path.write_text(configuration.replace('Frame Rate: 10', f'Frame Rate: {frame_rate}'))
        environment = {**screen.environment, 'ROS_NAMESPACE': 'omron_ld90', 'GALLIUM_HUD': 'fps',
                       'GALLIUM_HUD_PERIOD': '1', 'GALLIUM_HUD_VISIBLE': 'false',
                       'GALLIUM_HUD_DUMP_DIR': folder}
        rviz = subprocess.Popen(
            ['rviz', '-d', str(path), *rendering_arguments(), '__name:=rviz'], env=environment,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            time.sleep(SETTLE)
            drawn = len(frames_in(folder))
            before = {pid: cpu_seconds(pid) for pid in [rviz.pid, *descendants(stack)]}
            time.sleep(MEASURE)
            shares = {node_name(pid): (cpu_seconds(pid) - used) / MEASURE
                      for pid, used in before.items()}
            return Figures(statistics.median(frames_in(folder)[drawn:]), shares)
        finally:
            rviz.send_signal(signal.SIGINT)
            rviz.wait(20)


def frames_in(folder: str) -> List[float]:
    """Returns the frame rates that Mesa has written up to now."""
    file = Path(folder) / 'fps'
    return [float(line) for line in file.read_text().split()] if file.exists() else []


def main() -> None:
    """Prints the table."""
    missing = missing_programs()
    if missing:
        print(f'Skipped, because these programs are not installed: {", ".join(missing)}')
        return
    port = free_port()
    os.environ['ROS_MASTER_URI'] = f'http://127.0.0.1:{port}'
    screen = Screen()
    stack = subprocess.Popen(
        ['roslaunch', '-p', str(port), 'omron_ld90', 'full_stack.launch', 'rviz:=false',
         f'arcl_port:={free_port()}', f'outgoing_port:={free_port()}'],
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        time.sleep(SETTLE)
        fast, fast_floor = (measure(screen, stack.pid, text, 30) for text in (SHIPPED, EMPTY))
        slow, slow_floor = (measure(screen, stack.pid, text, 10) for text in (SHIPPED, EMPTY))
    finally:
        stack.send_signal(signal.SIGINT)
        stack.wait(30)
        screen.close()
    feeding = sum(slow.shares[node] for node in NODES)
    print_table([
        ('frames a second at Frame Rate 30', f'{fast.frames:.1f}', f'{fast_floor.frames:.1f}',
         '>= 20'),
        ('CPU of RViz as shipped (Frame Rate 10)', f'{100 * slow.shares["rviz"]:.0f} % of a core',
         f'{100 * slow_floor.shares["rviz"]:.0f} %', '< 60 %'),
        ('CPU of the visualisation nodes, 2 Hz', f'{100 * feeding:.1f} % of a core', '', '< 8 %')],
        ('RViz on lab.map, software rendering, 1280 x 900', 'measured', 'floor (no displays)',
         'goal'))
    print()
    print_table([(f'`{node}`', f'{100 * slow.shares[node]:.1f}') for node in NODES],
                ('node', '% of a core'))


if __name__ == '__main__':
    main()
