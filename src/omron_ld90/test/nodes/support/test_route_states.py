"""numpy and rospy read the same from a route report; its length is limited."""
from __future__ import annotations

import io

from hypothesis import given
from hypothesis import strategies as st

from itrci_nav_msgs.msg import EdgeState, ExecutionRouteStates
from omron_ld90.nodes.support.route_states import MAX_EDGES, RouteStates

EDGES = st.lists(st.tuples(st.integers(-2**31, 2**31 - 1), st.integers(0, 255)), max_size=20)


def written(edges, frame_id: str = 'map', reason: str = '') -> bytes:
    message = ExecutionRouteStates(
        route_id=-7, reason=reason, edge_states=[EdgeState(*edge) for edge in edges])
    message.header.frame_id = frame_id
    message.header.stamp.secs = 12
    message.symbolic_pose.edge_id, message.symbolic_pose.percentage = -3, 12.5
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


@given(edges=EDGES, frame_id=st.text(max_size=5), reason=st.text(max_size=5))
def test_it_says_what_the_plain_message_says(edges, frame_id, reason):
    data = written(edges, frame_id, reason)
    ours, plain = RouteStates().deserialize(data), ExecutionRouteStates().deserialize(data)
    assert ours.edges.tolist() == [(edge.edge_id, edge.state) for edge in plain.edge_states]
    for field in ('header', 'route_id', 'symbolic_pose', 'reason'):
        assert getattr(ours, field) == getattr(plain, field)
    assert not ours.too_long


def test_a_forged_report_of_a_million_edges_is_not_kept():
    ours = RouteStates().deserialize(written([(1, 1)] * (MAX_EDGES + 1)))
    assert ours.too_long and len(ours.edges) == 0
    assert ours.route_id == -7


def test_publishers_see_the_plain_type():
    assert RouteStates._md5sum == ExecutionRouteStates._md5sum
