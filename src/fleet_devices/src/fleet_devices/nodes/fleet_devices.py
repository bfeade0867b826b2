"""fleet_devices: drives the doors, lights and other devices of a site, for all requesters.

Subscribes
    /device_request (itrci_nav_msgs/DeviceRequest)
    /devices/<device>/step_command (itrci_nav_msgs/StepCommand), for each machine
Publishes
    /device_states (itrci_nav_msgs/DeviceState): at each change, and 2 Hz for each device
    /devices/<device>/step_states (itrci_nav_msgs/StepStates, latched), for each machine: at each
                       change, and 1 Hz
    /diagnostics
Client of
    execute_command of robots whose outputs and inputs drive a device
Parameters
    ~work_file         string  (required)  the site's devices
    ~graph_file        string  (required)  the trajectory graph, for the edges in the work file
    ~memory_file       string  fleet_devices/memory.json  keeps the holders of each device; a
                                        relative path begins in ROS_HOME
    ~steps_file        string  fleet_devices/steps.json  keeps the steps of each machine; used only
                                        if the site has machines
    ~period            float   0.2 s    between two readings of a device
    ~offline_after     float   2 s      without a reading until a device is OFFLINE
    ~simulated_travel  float   3 s      for a simulated device to open, close or hand over
    ~simulated_faults  list    []       faults of simulated devices: device, fault, begin, end
"""
from __future__ import annotations

import time
from functools import partial
from typing import Dict, Hashable, Optional

import rospy

from fleet_devices.core.device import Reading
from fleet_devices.core.devices import Devices, StoredDevices
from fleet_devices.core.hand_over import Signals
from fleet_devices.core.hand_overs import HandOvers, StoredHandOvers
from fleet_devices.drivers.driver import ExchangeQueue
from fleet_devices.nodes.diagnostics import show_devices
from fleet_devices.nodes.memory_file import HOLDERS_LOST, STEPS_LOST, MemoryFile
from fleet_devices.nodes.settings import Settings
from fleet_devices.nodes.step_topics import StepTopics
from itrci_nav_msgs.msg import DeviceRequest, DeviceState, DeviceUse
from node_lifecycle import run, warn
from node_lifecycle.event_loop import EventLoop
from node_lifecycle.worker import start_worker
from route_protocol.device_messages import (
    WrongDeviceMessage,
    device_request_of,
    fill_device_report,
)
from route_protocol.devices import DeviceReport
from route_protocol.devices import DeviceRequest as Request
from route_protocol.steps import StepCommand as Command
from route_protocol.vehicle import milliseconds

TICK = 0.05  # s between two checks for what is due


class DeviceNode:
    """The node that the module describes. One thread owns the devices."""

    def __init__(self) -> None:
        settings = Settings()
        memory = MemoryFile(settings.memory_file, '~memory_file', StoredDevices(), HOLDERS_LOST)
        self._loop = EventLoop(self._tick, TICK)
        self._devices = Devices(settings.limits, memory.read(), memory.write, milliseconds(),
                                settings.periods, time.monotonic())
        self._drivers, self._machine_drivers = settings.lines(), settings.machine_lines()
        self._machines = machines_of(settings)
        self._lines: Dict[Hashable, ExchangeQueue] = {
            peer: ExchangeQueue() for peer, _ in (*self._drivers.values(),
                                                  *self._machine_drivers.values())}
        self._steps = StepTopics(settings.machines, self._on_command)
        self._states = rospy.Publisher('/device_states', DeviceState, queue_size=1000,
                                       tcp_nodelay=True)
        rospy.Subscriber('/device_request', DeviceRequest, self._on_request, queue_size=1000,
                         tcp_nodelay=True)
        show_devices(settings.devices, self._devices, self._machines)
        for peer, line in self._lines.items():
            start_worker(f'line to {peer}', line.run)
        start_worker('devices', self._loop.run)

    # --- callbacks --------------------------------------------------------------------------------

    def _on_request(self, message: DeviceRequest) -> None:
        try:
            request = device_request_of(message)
        except WrongDeviceMessage as wrong:
            warn('request', f'A request for a device is ignored: {wrong}.')
            return
        self._loop.put(lambda: self._receive(request))

    def _on_command(self, name: str, command: Command) -> None:
        self._loop.put(lambda: self._receive_step(name, command))

    def _on_end(self, name: str, reading: Optional[Reading], problem: str) -> None:
        self._loop.put(lambda: self._ended(name, reading, problem))

    def _on_signals(self, name: str, signals: Optional[Signals], problem: str) -> None:
        self._loop.put(lambda: self._machine_ended(name, signals, problem))

    # --- in the thread that owns the devices ------------------------------------------------------

    def _receive(self, request: Request) -> None:
        refusal = self._devices.receive(request, time.monotonic(), rospy.get_time())
        if refusal:
            warn('refusal', f'{request.requester} asks for device {request.device}, in vain: '
                            f'{refusal}.')
        self._work()

    def _receive_step(self, name: str, command: Command) -> None:
        self._machines.receive(name, command, time.monotonic())
        self._work()

    def _machine_ended(self, name: str, signals: Optional[Signals], problem: str) -> None:
        self._machines.ended(name, signals, problem, time.monotonic())
        self._work()

    def _ended(self, name: str, reading: Optional[Reading], problem: str) -> None:
        self._devices.ended(name, reading, problem, time.monotonic())
        self._work()

    def _tick(self) -> None:
        self._devices.tick(time.monotonic())
        self._machines.tick(time.monotonic())
        self._work()

    def _work(self) -> None:
        now = time.monotonic()
        for name, exchange in self._devices.begin_due(now):
            peer, driver = self._drivers[name]
            self._lines[peer].put(partial(driver.exchange, exchange.output),
                                  partial(self._on_end, name))
        for name, start in self._machines.begin_due(now):
            peer, machine = self._machine_drivers[name]
            self._lines[peer].put(partial(machine.exchange, start),
                                  partial(self._on_signals, name))
        behind = rospy.get_time() - now  # s by which the monotonic clock is behind ROS time
        for report in self._devices.reports(now):
            self._states.publish(message_of(report, behind))
        for name, steps in self._machines.reports(now):
            self._steps.publish(name, steps)


def machines_of(settings: Settings) -> HandOvers:
    """Returns the machines of the site, with their stored memory."""
    if not settings.machines:
        return HandOvers({}, StoredHandOvers(), lambda _: None, 0, 0.0, 0.0)
    memory = MemoryFile(settings.steps_file, '~steps_file', StoredHandOvers(), STEPS_LOST)
    return HandOvers(settings.machine_limits, memory.read(), memory.write, milliseconds(),
                     settings.periods.exchange, time.monotonic())


def message_of(report: DeviceReport, behind: float) -> DeviceState:
    """Returns the message of a report. `behind`: s by which its clock is behind ROS time."""
    read_at = None if report.read_at is None else report.read_at + behind
    return fill_device_report(
        DeviceState(), report.at(report.since + behind, read_at), DeviceUse,
        lambda time: rospy.Time.from_sec(max(time, 0.0)))


def main() -> None:
    """Runs the node."""
    run('fleet_devices', DeviceNode)
