"""A node under ROS_NAMESPACE works, or one sentence says why it cannot."""
from __future__ import annotations

import pytest

from node_lifecycle import ConfigurationError
from node_lifecycle.startup import check_namespace


@pytest.mark.parametrize('namespace', ['/', '/omron_ld90/', '/hall'])
def test_a_node_works_at_the_top_and_in_the_namespace_of_its_robot(namespace):
    check_namespace(namespace)


@pytest.mark.parametrize('namespace', ['/hall/omron_ld90/', '/a/b/c'])
def test_a_namespace_within_another_is_refused_with_the_way_out(namespace):
    with pytest.raises(ConfigurationError, match=f'{namespace.rstrip("/")}, .*unset ROS_NAMESPACE'):
        check_namespace(namespace)
