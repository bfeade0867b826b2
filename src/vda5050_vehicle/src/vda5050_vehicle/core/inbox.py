"""Reads the messages of the master; a refusal names the ids that can be read."""
from __future__ import annotations

from typing import Any, Iterator, Mapping, Tuple

from vda5050_protocol import problems as e
from vda5050_protocol.codecs import Codec
from vda5050_protocol.fields import TEXT, UINT, Kind, Malformed, read_json
from vda5050_protocol.order_rules import check_order
from vda5050_protocol.values import Error, ErrorReference
from vda5050_vehicle.core.identity import Identity

# The ids with which a master finds the refused message. With an actionId, the master would take the
# error for an error of one action.
_IDS: Mapping[str, Tuple[Tuple[str, Kind], ...]] = {
    'order': (('orderId', TEXT), ('orderUpdateId', UINT)), 'instantActions': ()}


class MessageRefused(Exception):
    """A message that cannot be read, or is for another vehicle; `error` is to be reported."""

    def __init__(self, error: Error) -> None:
        super().__init__(error.description)
        self.error = error


class Inbox:
    """Reads the messages to one vehicle."""

    def __init__(self, identity: Identity, codec: Codec) -> None:
        self._identity = identity
        self._codec = codec

    def read(self, topic: str, payload: bytes) -> Any:
        """Returns the message on `topic`; raises MessageRefused."""
        try:
            header, message = self._codec.read(topic, payload)
            self._identity.check(header)
            if topic == 'order':
                check_order(message)
        except Malformed as problem:
            raise MessageRefused(e.VALIDATION_ERROR.error(
                str(problem), ErrorReference('topic', topic), *_ids_in(topic, payload),
                ErrorReference('field', problem.path))) from None
        return message


def _ids_in(topic: str, payload: bytes) -> Iterator[ErrorReference]:
    """Yields those ids that can be read in a malformed message."""
    try:
        message = read_json(payload)
    except Malformed:
        return
    for key, kind in _IDS[topic]:
        try:
            yield ErrorReference(key, str(kind.read(message.get(key), key)))
        except Malformed:
            continue
