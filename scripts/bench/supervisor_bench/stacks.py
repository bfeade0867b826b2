"""The systems to measure: one LD-90 with or without its fleet manager, or simulated AGVs."""
from __future__ import annotations

import signal
import subprocess
import tempfile
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from fleet_bench.instances import aisles
from measuring.ros_master import own_ros_master

from trajectory_graph import save_graph

ROBOT = '''<launch>
  <include file="$(find omron_ld90)/launch/sim.launch">
    <arg name="arcl_port" value="{robot}"/> <arg name="outgoing_port" value="{outgoing}"/>
    <arg name="sim_speed" value="{speed}"/>
  </include>
  <include file="$(find omron_ld90)/launch/robot.launch">
    <arg name="arcl_port" value="{tap}"/> <arg name="outgoing_port" value="{outgoing}"/>
    <arg name="password_file" value="$(find omron_ld90_sim)/config/simulator_password"/>
    <arg name="graph_file" value="$(find omron_ld90)/maps/lab_graph.yaml"/>
    <arg name="dock_vertex" value="16"/>
  </include>
</launch>'''
ROBOT_WITH_STEPS = ROBOT.replace('</launch>', '''
  <include file="$(find omron_ld90)/launch/steps.launch"/>
</launch>''')
MANAGER = '''<launch>
  <include file="$(find graph_fleet_manager)/launch/fleet_manager.launch">
    <arg name="graph_file" value="{graph}"/> <arg name="fleet_file" value="{fleet}"/>
    <arg name="journal" value="{folder}/fleet.sqlite"/> <arg name="sim_speed" value="{speed}"/>
    <arg name="closed_edges_file" value="{folder}/closed.json"/>
    <arg name="graph_in_force_file" value="{folder}/in_force.yaml"/>
  </include>
</launch>'''
MANAGER_AT_WORK = MANAGER.replace('  </include>', '''    <arg name="work_file" value="{work}"/>
  </include>
  <node name="fleet_devices" pkg="fleet_devices" type="fleet_devices">
    <param name="work_file" value="{work}"/> <param name="graph_file" value="{graph}"/>
    <param name="memory_file" value="{folder}/devices.json"/>
  </node>''')
AGVS = '''<launch>
  <node name="agvs" pkg="graph_fleet_manager" type="agv_sim">
    <param name="graph_file" value="{graph}"/> <param name="fleet_file" value="{fleet}"/>
  </node>
  <node name="random_missions" pkg="graph_fleet_manager" type="random_missions">
    <param name="seed" value="1"/>
  </node>
</launch>'''


class Stack:
    """A separate ROS master, and launches under this master; for use in a `with` statement."""

    def __init__(self) -> None:
        self._context = ExitStack()
        self.folder = Path(self._context.enter_context(tempfile.TemporaryDirectory()))
        self._context.enter_context(own_ros_master())
        self._launched = 0

    def __enter__(self) -> Stack:
        return self

    def __exit__(self, *_: object) -> None:
        self._context.close()

    def launch(self, text: str, **values: Any) -> subprocess.Popen:
        """Starts roslaunch with a launch text."""
        self._launched += 1
        path = self.folder / f'{self._launched}.launch'
        path.write_text(text.format(folder=self.folder, **values))
        log = (self.folder / f'{self._launched}.log').open('w')
        process = subprocess.Popen(['roslaunch', '--wait', str(path)], stdout=log,
                                   stderr=subprocess.STDOUT)
        self._context.callback(self.end, process)
        return process

    @staticmethod
    def end(process: subprocess.Popen) -> None:
        """Ends a started roslaunch."""
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(40)

    def agv_fleet(self, count: int) -> dict:
        """Returns the files of a warehouse with `count` AGVs, each at its own station."""
        graph, stations = aisles(500)
        step = len(stations) // count
        save_graph(graph, self.folder / 'graph.yaml')
        lines = ['clearance: 0.1', 'robot_types:',
                 '- {name: agv, radius: 0.43, speed: 1.0, release_ahead: 0.0}', 'robots:']
        lines += [f'- {{name: agv_{k}, type: agv, vertex: {vertex}, driver: agv}}'
                  for k, vertex in enumerate(stations[:count * step:step], 1)]
        (self.folder / 'fleet.yaml').write_text('\n'.join(lines) + '\n')
        return {'graph': self.folder / 'graph.yaml', 'fleet': self.folder / 'fleet.yaml'}
