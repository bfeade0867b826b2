"""Messages of the master as they come in: read, or refused under the ids that can be read."""
from __future__ import annotations

from typing import Any, Iterator

from vda5050_vehicle.core.identity import Identity
from vda5050_vehicle.protocol import problems as e
from vda5050_vehicle.protocol.codecs import Codec
from vda5050_vehicle.protocol.fields import TEXT, UINT, Malformed, read_json
from vda5050_vehicle.protocol.order_rules import check_order
from vda5050_vehicle.protocol.values import Error, Reference

MAX_ACTION_IDS = 20  # that an error refers to


class Refused(Exception):
    """A message that cannot be read, or is for another vehicle; `error` is what to report."""

    def __init__(self, error: Error) -> None:
        super().__init__(error.description)
        self.error = error


class Inbox:
    """Reads what comes to one vehicle."""

    def __init__(self, identity: Identity, codec: Codec) -> None:
        self._identity = identity
        self._codec = codec

    def read(self, topic: str, payload: bytes) -> Any:
        """The message on `topic`; raises Refused."""
        try:
            header, message = self._codec.read(topic, payload)
            self._identity.check(header)
            if topic == 'order':
                check_order(message)
        except Malformed as problem:
            raise Refused(e.VALIDATION_ERROR.error(
                str(problem), Reference('topic', topic), *_ids_in(payload),
                Reference('field', problem.path))) from None
        return message


def _ids_in(payload: bytes) -> Iterator[Reference]:
    """Which order or actions a malformed message is about: a master waits for these ids."""
    try:
        message = read_json(payload)
    except Malformed:
        return
    for key, kind in (('orderId', TEXT), ('orderUpdateId', UINT)):
        try:
            yield Reference(key, str(kind.read(message.get(key), key)))
        except Malformed:
            continue
    actions = message.get('actions', message.get('instantActions'))
    for action in actions[:MAX_ACTION_IDS] if isinstance(actions, list) else ():
        try:
            yield Reference('actionId', TEXT.read(action['actionId'], 'actionId'))
        except (KeyError, TypeError, Malformed):
            continue
