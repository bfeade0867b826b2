"""The messages between a supervisor and its robots: they may come late, twice, or not at all."""
from __future__ import annotations

from random import Random
from typing import Dict, Iterator, List, Tuple

from fleet_core.supervision.actions import SendRoute
from fleet_simulation.on_the_way import OnTheWay
from route_protocol.values import RouteReport


class VirtualNetwork:
    """The orders on their way to robots, the reports on their way to the supervisor, and faults of
    both.

    loss    -- probability (0..1) that a message is lost
    repeats -- probability (0..1) that a message comes twice if it is not lost
    """

    def __init__(self, random: Random, loss: float, repeats: float) -> None:
        self.loss, self.repeats = loss, repeats
        self.silent: Dict[str, float] = {}
        """For each robot: time until which no report comes from it and no order reaches it."""
        self.deaf: Dict[str, float] = {}
        """For each robot: time until which no order reaches it, although it still reports."""
        self.late: Dict[str, float] = {}
        """For each robot: s by which its reports and refusals are delayed."""
        self.orders_late: Dict[str, float] = {}
        """For each robot: s by which orders to it are delayed. No order overtakes another one."""
        self.to_robots: List[SendRoute] = []
        """Orders that leave the supervisor's computer in the next step."""
        self._random = random
        self._under_way: List[Tuple[float, SendRoute]] = []
        self.reports: OnTheWay[Tuple[str, RouteReport]] = OnTheWay()
        """Reports to the supervisor, with the names of their robots."""

    def under_way(self, name: str) -> List[SendRoute]:
        """Returns the orders to a robot that have not arrived yet and may still arrive."""
        return [order for order in (*(late for _, late in self._under_way), *self.to_robots)
                if order.robot == name]

    def lose_messages(self) -> None:
        """Loses all messages on the supervisor's computer. Orders that have left the computer still
        arrive.
        """
        self.to_robots = []
        self.reports.lose()

    def arrived_orders(self, now: float) -> Iterator[SendRoute]:
        """Yields each order that a robot gets now, twice if it is repeated."""
        orders, self.to_robots = self.to_robots, []
        under_way, self._under_way = self._under_way, []
        last: Dict[str, float] = {}
        for at, order in [*under_way, *((now + self.orders_late.get(one.robot, 0.0), one)
                                        for one in orders)]:
            at = last[order.robot] = max(at, last.get(order.robot, 0.0))
            if at > now:
                self._under_way.append((at, order))
            elif self.hears(order.robot, now):
                yield from [order] * self.copies()

    def is_silent(self, name: str, now: float) -> bool:
        """Returns whether no report comes from a robot now."""
        return self.silent.get(name, 0.0) > now

    def hears(self, name: str, now: float) -> bool:
        """Returns whether orders reach a robot now."""
        return not self.is_silent(name, now) and self.deaf.get(name, 0.0) <= now

    def end_faults(self) -> None:
        """Loses and delays nothing from now on."""
        for fault in (self.silent, self.deaf, self.late, self.orders_late):
            fault.clear()
        self.loss = 0.0

    def carry_report(self, name: str, report: RouteReport, now: float) -> None:
        """Sends a robot's report to the supervisor; it may be delayed, lost or repeated."""
        for _ in range(self.copies()):
            self.reports.send((name, report), now + self.late.get(name, 0.0))

    def copies(self) -> int:
        """Returns how many copies of a message arrive: none, one or two."""
        if self._random.random() < self.loss:
            return 0
        return 2 if self._random.random() < self.repeats else 1
