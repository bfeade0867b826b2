"""Errors of an order that the JSON schemas allow."""
from __future__ import annotations

import json

import pytest
from vda_builders import say, way
from vda_messages import payload

from vda5050_protocol.codecs import VERSION_2_1
from vda5050_protocol.fields import Malformed
from vda5050_protocol.order_rules import check_order


def read(order):
    return VERSION_2_1.read('order', payload(order))[1]


@pytest.mark.parametrize('order', [
    way(8, 10).order('o'), way(8, 10, 12).order('o', base=1), way(8, 10, 12).order('o', base=2),
    way(8, 10, 12).order('o', first_sequence=8), way(8, 10).part(0, 0).order('o')])
def test_valid_orders(order):
    check_order(read(order))


@pytest.mark.parametrize('damage, path', [
    (lambda o: o.update(orderId=''), 'orderId'),
    (lambda o: o.update(nodes=[], edges=[]), 'nodes'),
    (lambda o: o.update(edges=o['edges'][1:]), 'edges'),
    (lambda o: o['nodes'][1].update(sequenceId=3), 'nodes[1].sequenceId'),
    (lambda o: [element.update(sequenceId=element['sequenceId'] + 1)
                for element in (*o['nodes'], *o['edges'])], 'nodes[0].sequenceId'),
    (lambda o: o['edges'][1].update(sequenceId=2), 'edges[1].sequenceId'),
    (lambda o: o['edges'][0].update(startNodeId='x'), 'edges[0].startNodeId'),
    (lambda o: o['edges'][1].update(endNodeId='x'), 'edges[1].endNodeId'),
    (lambda o: o['nodes'][0].update(released=False), 'nodes[0].released'),
    (lambda o: o['nodes'][2].update(released=False), 'edges[1].released'),
    (lambda o: o['edges'][1].update(released=False), 'edges[1].released'),
    (lambda o: (o['nodes'][1].update(released=False), o['edges'][0].update(released=False)),
     'edges[1].released'),
    (lambda o: o['nodes'][0].update(actions=[say('a'), say('a')]), 'actionId')])
def test_invalid_orders(damage, path):
    order = json.loads(json.dumps(way(8, 10, 12).order('o')))
    damage(order)
    with pytest.raises(Malformed) as caught:
        check_order(read(order))
    assert caught.value.path == path
