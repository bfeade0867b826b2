"""docs/reference/route_protocol.md names each field and each constant of the messages."""
from __future__ import annotations

import re
from pathlib import Path
from typing import Dict

import pytest

pytest.importorskip('itrci_nav_msgs')

from itrci_nav_msgs.msg import (  # noqa: E402
    EdgeState,
    ExecutionRouteStates,
    ReasonCode,
    RouteRefused,
    SymbolicPose,
    TargetRoute,
)

PAGE = (Path(__file__).resolve().parents[4] / 'docs/reference/route_protocol.md').read_text()


def told(field: str) -> Dict[str, int]:
    """Returns the constants in the page's row about a field."""
    row = re.search(rf'^\| (?:`\w+`, )*`{field}`.*? \|(.*)\|$', PAGE.partition(
        '## Values of the constants')[2], re.MULTILINE)
    return {name: int(value) for name, value in re.findall(r'([A-Z_]+) (\d+)', row.group(1))}


def constants(message: type) -> Dict[str, int]:
    return {name: value for name, value in vars(message).items() if name.isupper()}


@pytest.mark.parametrize('message', [TargetRoute, ExecutionRouteStates, EdgeState, SymbolicPose,
                                     RouteRefused], ids=lambda message: message.__name__)
def test_each_field_is_on_the_page(message):
    named = set(re.findall(r'`([\w.]+)`', PAGE))
    fields = {'header.stamp' if field == 'header' else field for field in message.__slots__}
    assert fields - named == set()


def test_each_constant_is_on_the_page_with_its_value():
    assert told('state') == constants(EdgeState)
    assert told('unready') == constants(ReasonCode)
    assert {**told('motion'), **told('epoch_cause')} == constants(ExecutionRouteStates)
