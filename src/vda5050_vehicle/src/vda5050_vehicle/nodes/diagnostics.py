"""The entries of the adapter in /diagnostics: the broker and the order."""
from __future__ import annotations

from typing import Callable

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from node_lifecycle import publish_diagnostics
from vda5050_mqtt.link import MqttLink
from vda5050_vehicle.core.vehicle import VdaVehicle
from vda5050_vehicle.nodes.settings import VehicleSettings


def show_state(settings: VehicleSettings, vehicle: VdaVehicle, link: MqttLink,
               problem: Callable[[], str]) -> None:
    """Publishes the state of the broker connection and of the order.

    problem -- returns the reason why the broker is not connected
    """
    def broker(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        if link.connected:
            status.summary(DiagnosticStatus.OK, 'connected')
        else:
            status.summary(DiagnosticStatus.ERROR, f'not connected: {problem()}')
        status.add('broker', str(settings.broker))
        return status

    def order(status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        failure = vehicle.state.errors.failure
        if failure:
            status.summary(DiagnosticStatus.ERROR, failure.description)
        else:
            status.summary(DiagnosticStatus.OK, 'order active' if vehicle.state.busy else 'idle')
        status.add('order', vehicle.state.order.order_id)
        status.add('remaining nodes', str(max(len(vehicle.state.order.nodes) - 1, 0)))
        return status

    publish_diagnostics(settings.prefix, {'broker': broker, 'order': order})
