"""A node registers anew when the master does not know it, and only then."""
from __future__ import annotations

import pytest

from node_lifecycle.master_watch import MasterWatch


class Master:
    """Knows the node or not, or is not there."""

    def __init__(self, known: bool = True, there: bool = True) -> None:
        self.known = known
        self.there = there

    def is_known(self) -> bool:
        if not self.there:
            raise ConnectionRefusedError
        return self.known

    def register(self) -> None:
        if not self.there:
            raise ConnectionRefusedError
        self.known = True


@pytest.mark.parametrize(('master', 'registers'), [
    (Master(known=True), False), (Master(known=False), True), (Master(there=False), False)])
def test_a_node_registers_where_it_is_not_known(master, registers):
    watch = MasterWatch(master.is_known, master.register)
    assert watch.look() is registers
    assert watch.look() is False


def test_a_master_that_comes_back_without_knowing_the_node_is_told_of_it():
    master = Master()
    watch = MasterWatch(master.is_known, master.register)
    master.there = False
    assert not watch.look()
    master.there, master.known = True, False
    assert watch.look()
