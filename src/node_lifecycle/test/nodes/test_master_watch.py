"""A node registers again only if the master does not know it."""
from __future__ import annotations

from typing import List

import pytest
import rosgraph
import rospy

from node_lifecycle import master_watch
from node_lifecycle.kept_parameters import KeptParameters
from node_lifecycle.master_watch import MasterWatch, ThisNode


class Master:
    """A master that knows two, one or none of the node's two registrations, or that does not run.
    """

    def __init__(self, known: int = 2, there: bool = True) -> None:
        self.known = known
        self.there = there
        self.restored = 0
        self.ends_in_between = False

    def _answer(self, answer: bool) -> bool:
        if not self.there:
            raise ConnectionRefusedError
        return answer

    def is_known(self) -> bool:
        return self._answer(self.known > 0)

    def is_complete(self) -> bool:
        return self._answer(self.known == 2)

    def restore(self) -> None:
        self._answer(True)
        self.restored += 1
        # the first of the two registrations reached the master before the master ended
        self.known = 1 if self.ends_in_between else 2


@pytest.mark.parametrize(('master', 'registers'), [
    (Master(known=2), False), (Master(known=0), True), (Master(there=False), False)])
def test_a_node_registers_where_it_is_not_known(master, registers):
    watch = MasterWatch(master)
    assert watch.register_again() is registers
    assert watch.register_again() is False


def test_a_master_that_comes_back_without_knowing_the_node_is_told_of_it():
    master = Master()
    watch = MasterWatch(master)
    master.there = False
    assert not watch.register_again()
    master.there, master.known = True, 0
    assert watch.register_again()


def test_a_master_that_ends_while_a_node_registers_is_told_the_rest():
    master = Master(known=0)
    watch = MasterWatch(master)
    master.ends_in_between = True
    assert not watch.register_again() and master.is_known(), (
        'the new master must have the later registrations')
    master.ends_in_between = False
    assert watch.register_again() and master.is_complete()
    assert not watch.register_again() and master.restored == 2


class Rosmaster:
    """Replaces the ROS master in tests: it has the functions that a node calls.

    A test registers a topic or service with `notify_added`.
    """

    def __init__(self) -> None:
        self.nodes: List[str] = []
        self.registered: List[tuple] = []
        self.parameters = {}

    def lookupNode(self, name):
        return self._look(name in self.nodes)

    def lookupService(self, name):
        return self._look(any(entry[1:] == ('srv', name) for entry in self.registered))

    def _look(self, there):
        if not there:
            raise rosgraph.MasterError('unknown')
        return 'uri'

    def getSystemState(self):
        return [[[name, [node]] for node, kind, name in self.registered if kind == wanted]
                for wanted in ('pub', 'sub', 'srv')]

    def hasParam(self, name):
        return name in self.parameters

    def setParam(self, name, value):
        assert not self.registered, 'a registered node counts as complete'
        self.parameters[name] = value

    def notify_added(self, name, _, kind):
        self.registered.append(('/me', kind, name))


@pytest.fixture
def rosmaster(monkeypatch) -> Rosmaster:
    master = Rosmaster()
    monkeypatch.setattr(rospy, 'get_name', lambda: '/me')
    monkeypatch.setattr(rospy, 'resolve_name', lambda name: name.replace('~', '/me/'))
    monkeypatch.setattr(master_watch, 'get_registration_listeners', lambda: master)
    monkeypatch.setattr(master_watch, '_registrations', lambda: {
        ('pub', '/rosout', 'Log'), ('sub', '/graph', 'Graph'), ('srv', '/me/get_loggers', 'uri')})
    return master


def test_a_line_of_the_log_makes_no_node_known(rosmaster):
    rosmaster.nodes.append('/me')  # a real master adds a node that asks for a parameter
    watch = MasterWatch(ThisNode(rosmaster, KeptParameters()))
    assert watch.register_again()
    assert {name for _, _, name in rosmaster.registered} == {
        '/rosout', '/graph', '/me/get_loggers'}
    assert not watch.register_again()


def test_a_new_master_has_the_parameters_of_the_node_again(rosmaster):
    parameters = KeptParameters()
    parameters.keep('/me', {'file': 'f.yaml', 'limits': {'speed': 1.5}, 'record': 'old'},
                    but=('/me/record',))
    parameters.keep('/robot_description', '<robot/>')
    rosmaster.parameters['/me/file'] = 'set by a new launch'
    assert MasterWatch(ThisNode(rosmaster, parameters)).register_again()
    assert rosmaster.parameters == {'/me/file': 'set by a new launch', '/me/limits/speed': 1.5,
                                    '/robot_description': '<robot/>'}
