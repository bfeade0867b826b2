"""Runs the master of vda5050-sdk for test_vda_foreign_master.py, in its own environment.

For each act or message, the program reads one line of JSON. Its answer has the unchanged messages
that the master sends, and the errors that the master found.
"""
import asyncio
import json
import sys

from vda5050.client.master.client import MasterClient
from vda5050.config import MasterConfig
from vda5050.domain.order.builder import OrderBuilder
from vda5050.model.common import Action, ActionParameter, NodePosition
from vda5050.model.order import Edge, Node
from vda5050.testing.memory_transport import MemoryTransport
from vda5050.validation.schema_validator import SchemaValidator

TARGET = 'OMRON/lab'


class Master:
    def __init__(self):
        self.transport = MemoryTransport()
        # The monitor treats the horizon in a state as a fault, though the standard requires it.
        config = MasterConfig(progress_monitor=False)
        self.client = MasterClient(config, transport=self.transport)
        self.wrong = []
        for listen in (self.client.on_error, self.client.on_vehicle_error):
            listen(lambda *event: self.wrong.append(repr(event)))

    async def receive(self, topic, message):
        self.wrong += SchemaValidator().errors(topic, message)
        await self.transport.deliver(f'uagv/v2/{TARGET}/{topic}', json.dumps(message).encode())

    async def order(self, order_id, places, released, action_at):
        builder = OrderBuilder(order_id=order_id, manufacturer='OMRON', serial_number='lab')
        for number, (name, x, y) in enumerate(places):
            actions = [Action(action_type='say', action_id=f'say-{name}', blocking_type='SOFT',
                              action_parameters=[ActionParameter(key='text', value='hello')])]
            builder.add_node(name, x=x, y=y, map_id='map', released=number < released,
                             actions=actions if number == action_at else [])
        for (one, _, _), (other, _, _) in zip(places, places[1:]):
            builder.add_edge(one, other)
        await self.accepted(self.client.dispatch(builder.build(), TARGET))

    async def extend(self, places):
        """Releases further places; `places` begins with the last place that was released."""
        nodes = [Node(node_id=name, sequence_id=0, released=True,
                      node_position=NodePosition(x=x, y=y, map_id='map'))
                 for name, x, y in places[1:]]
        edges = [Edge(edge_id=f'{one}->{other}', sequence_id=0, released=True, start_node_id=one,
                      end_node_id=other) for (one, _, _), (other, _, _) in zip(places, places[1:])]
        await self.accepted(self.client.extend_base(TARGET, nodes, edges))

    async def accepted(self, sending):
        result = await sending
        if not result.accepted:
            self.wrong.append(repr(result))

    async def act(self, name):
        await getattr(self.client, name)(TARGET)


async def main():
    master = Master()
    await master.client.connect()
    for line in sys.stdin:
        name, *arguments = json.loads(line)
        master.transport.published.clear()
        master.wrong.clear()
        await getattr(master, name)(*arguments)
        print(json.dumps([[[message.topic, message.payload.decode()]
                           for message in master.transport.published], master.wrong]), flush=True)


asyncio.run(main())
