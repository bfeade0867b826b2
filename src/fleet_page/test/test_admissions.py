"""Before a login, no client can take all places, and a new connection is let in."""
from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fleet_page.core.admissions import EACH_SECOND, MOST, MOST_OF_ADDRESS, Admissions, place_of

EVENTS = st.lists(st.tuples(st.integers(0, 20), st.integers(1, 60), st.booleans()), max_size=60)


@given(EVENTS)
def test_the_limits_hold_and_who_has_few_loses_none_to_who_has_many(events):
    admissions, open_, number = Admissions(), {}, 0
    for address, count, leaves in events:
        for _ in range(count):
            number += 1
            before = {other: admissions.of_address(str(other)) for other in range(21)}
            displaced = admissions.arrive(number, str(address))
            if displaced is not None:
                loser = open_.pop(displaced)
                assert before[loser] == max(before.values()) or loser == address
            open_[number] = address
            assert len(admissions) == len(open_) <= MOST
            assert admissions.of_address(str(address)) <= MOST_OF_ADDRESS
        if leaves and open_:
            gone = next(iter(open_))
            del open_[gone]
            admissions.leave(gone)
            admissions.leave(gone)
    assert all(admissions.of_address(str(address)) == list(open_.values()).count(address)
               for address in range(21))


def test_an_address_that_fills_its_places_must_bring_requests_and_the_others_need_not():
    admissions = Admissions()
    for number in range(MOST_OF_ADDRESS):
        assert not admissions.must_bring_request('a', 0.0)
        admissions.arrive(number, 'a')
    refused = [admissions.must_bring_request('a', 0.0) for _ in range(3 * int(EACH_SECOND))]
    assert refused.count(False) == EACH_SECOND
    assert not admissions.must_bring_request('b', 0.0)


def test_many_addresses_that_fill_all_places_leave_the_door_open_to_another():
    admissions = Admissions()
    for number in range(2 * MOST):
        admissions.arrive(number, f'a{number % 200}')
    refused = [admissions.must_bring_request(f'a{number % 200}', 0.0)
               for number in range(3 * int(EACH_SECOND))]
    assert refused.count(False) == EACH_SECOND
    assert not admissions.must_bring_request('b', 0.0)
    assert admissions.arrive('honest', 'b') is not None
    for number in range(2 * MOST, 4 * MOST):
        assert admissions.arrive(number, f'a{number % 200}') != 'honest'


@pytest.mark.parametrize('one, other, same', [
    ('2001:db8:0:1::1', '2001:db8:0:1:ffff::2', True),
    ('2001:db8:0:1::1', '2001:db8:0:2::1', False),
    ('fe80::1%eth0', 'fe80::2%eth1', True), ('::ffff:10.0.0.1', '10.0.0.1', True),
    ('10.0.0.1', '10.0.0.2', False), ('', '', True)])
def test_an_address_of_ip_version_6_counts_as_its_network(one, other, same):
    assert (place_of(one) == place_of(other)) is same
