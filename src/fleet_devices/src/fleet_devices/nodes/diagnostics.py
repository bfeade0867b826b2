"""The devices in /diagnostics."""
from __future__ import annotations

from typing import Mapping

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from fleet_core.work.devices import Device, DeviceKind
from fleet_devices.core.device import Stage
from fleet_devices.core.devices import Devices
from fleet_devices.core.hand_overs import HandOvers
from node_lifecycle import publish_diagnostics
from node_lifecycle.diagnostics import Task
from route_protocol.devices import DeviceFault, DeviceMode


def show_devices(site: Mapping[str, Device], devices: Devices, machines: HandOvers) -> None:
    """Publishes a status for each device, and a status for the memory."""
    publish_diagnostics('none', {'memory': memory_task(devices, machines), **{
        f'{device.kind.value.replace("_", " ")} {name}': device_task(name, devices)
        for name, device in site.items()}, **{
        f'{DeviceKind.MACHINE.value} {name}': machine_task(name, machines)
        for name in machines.names}})


def machine_task(name: str, machines: HandOvers) -> Task:
    """Returns the diagnostics of a machine: its phase, and why it was not read."""
    def show(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        machine = machines[name]
        words = machine.phase.value
        if machine.problem:
            status.summary(DiagnosticStatus.ERROR, f'{words}: {machine.problem}')
        else:
            status.summary(DiagnosticStatus.OK, words)
        status.add('step', str(machine.key or ''))
        return status
    return show


def memory_task(devices: Devices, machines: HandOvers) -> Task:
    """Returns the diagnostics of the memory: an error while it cannot be stored."""
    def memory(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        problem = devices.problem or machines.problem
        if problem:
            status.summary(DiagnosticStatus.ERROR, 'the memory cannot be stored, so no request is '
                                                   f'taken: {problem}')
        else:
            status.summary(DiagnosticStatus.OK, 'stored')
        return status
    return memory


def device_task(name: str, devices: Devices) -> Task:
    """Returns the diagnostics of a device: its mode, its holders, and its fault."""
    def show(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        device = devices[name]
        report = device.report(name)
        level, text = DiagnosticStatus.OK, report.mode.name.lower()
        if report.fault is not DeviceFault.NONE:
            level, text = DiagnosticStatus.ERROR, f'{text}: {report.reason}'
        elif device.stage is Stage.FOUND:
            level, text = DiagnosticStatus.WARN, (
                f'{text}: its holders are not known. When it is empty: device release '
                f'{name} --of unknown')
        elif device.stage is Stage.LEFT and report.mode is DeviceMode.OPEN:
            level, text = DiagnosticStatus.WARN, (
                f'open, without a holder. To close it: device release {name}')
        status.summary(level, text)
        status.add('held by', ', '.join(use.requester for use in report.obeyed if use.holds))
        return status
    return show
