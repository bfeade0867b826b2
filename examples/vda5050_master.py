#!/usr/bin/env python3
"""Sends a VDA 5050 order to a vehicle, and prints each node that the vehicle reaches.

    examples/vda5050_master.py 127.0.0.1 18830 uagv/v2/OMRON/omron_ld90 order.json

Exit status 0: the vehicle stands at the last node; 1: the vehicle reports an error.
"""
from __future__ import annotations

import argparse
import json
import sys
import threading
from pathlib import Path
from typing import Any, Dict, Optional

import paho.mqtt.client as mqtt


class Master:
    """Sends one order and follows it to its last node.

    topic   -- topic prefix of the vehicle: interface/version/manufacturer/serial number
    order   -- the order, as in the standard
    outcome -- exit status; None: the order still runs
    done    -- set when the order has ended
    """

    def __init__(self, topic: str, order: Dict[str, Any]) -> None:
        self.topic = topic
        self.order = order
        self.outcome: Optional[int] = None
        self.done = threading.Event()
        self._node = ''
        self._is_sent = False

    def on_connect(self, client: mqtt.Client, *_: Any) -> None:
        """Subscribes to the vehicle's state."""
        client.subscribe(f'{self.topic}/state', qos=1)

    def on_message(self, client: mqtt.Client, _: Any, message: mqtt.MQTTMessage) -> None:
        """Handles a state of the vehicle; sends the order when the first state arrives."""
        state = json.loads(message.payload)
        if not self._is_sent:  # the first state shows that the vehicle is connected
            client.publish(f'{self.topic}/order', json.dumps(self.order), qos=1)
            self._is_sent = True
            return
        for error in state['errors']:
            print(f'{error["errorType"]}: {error.get("errorDescription", "")}')
            self._end(1)
        if state['orderId'] != self.order['orderId']:
            return
        if state['lastNodeId'] != self._node:
            self._node = state['lastNodeId']
            print(f'node {self._node}', flush=True)
        if not state['nodeStates'] and not state['driving']:
            self._end(0)

    def _end(self, outcome: int) -> None:
        self.outcome = outcome if self.outcome is None else self.outcome
        self.done.set()


def main() -> int:
    """Returns 0 when the vehicle has completed the order, 1 when it reports an error."""
    parser = argparse.ArgumentParser(description='Sends a VDA 5050 order to a vehicle, and prints '
                                                 'each node that the vehicle reaches.')
    parser.add_argument('broker')
    parser.add_argument('port', type=int)
    parser.add_argument('topic', help='topic prefix: interface/version/manufacturer/serial number')
    parser.add_argument('order', type=Path, help='file with the order (JSON)')
    arguments = parser.parse_args()
    master = Master(arguments.topic, json.loads(arguments.order.read_text(encoding='utf-8')))
    client = (mqtt.Client() if not hasattr(mqtt, 'CallbackAPIVersion')
              else mqtt.Client(mqtt.CallbackAPIVersion.VERSION1))
    client.on_connect, client.on_message = master.on_connect, master.on_message
    client.connect_async(arguments.broker, arguments.port)
    client.loop_start()  # repeats the connection attempt until the broker answers
    master.done.wait()
    client.disconnect()
    client.loop_stop()
    return 1 if master.outcome else 0


if __name__ == '__main__':
    sys.exit(main())
