"""Disturbs the fleet: faults of robots, acts of people, closed edges, programs that end or hang."""
from __future__ import annotations

import enum
import math
import os
import signal
import threading
import time
import xmlrpc.client
from contextlib import contextmanager
from dataclasses import dataclass
from random import Random
from typing import Callable, Dict, Iterator, List, Sequence, Tuple

import rosgraph
from ros_master import RosMaster

from itrci_nav_msgs.msg import EdgeCommand, FleetRobot, MissionCommand
from soaking.fleet import Fleet
from soaking.hall import Hall
from soaking.launch import Launch, process_of
from soaking.simulators import Simulators
from soaking.work import SoakPlc
from world.witness import Witness

RECOVERS = 8.0  # s within which a robot can be reached after a program or link is back
MASTER_RECOVERS = 15.0  # s within which all nodes must register at a new ROS master
SLOW = 0.15  # speed of the LD-90s' clocks, so low that robots still drive when their link is back
BRAKES = RECOVERS + 3.0 / SLOW  # s within which a slow LD-90 stands still after the link is back
OWED = 9.0  # s for which the soak watches an owed stop, including the grace of the witness
CLEAR = 1.6  # m: least distance to all other robots at a place to which a robot is carried
ON_GRAPH = 0.35  # m from a vertex; a robot that is nearer counts as on the graph
SETTLES = 4.0  # s after which a carried robot has reported its new place
TRIES = 5  # refused joins after which a robot is carried away
NEEDS_PERSON = (FleetRobot.TAKEN_OVER, FleetRobot.FAILED, FleetRobot.OFF_GRAPH,
                FleetRobot.OUT_OF_SERVICE)
LD90_NODES = ('omron_controller', 'omron_connection_receiver', 'omron_edges_to_vertices',
              'robot_state_publisher')
MANAGER_NODES = ('path_supervisor', 'path_planner', 'graph_server', 'fleet_visualisation',
                 'fleet_devices')


class Effect(enum.Flag):
    """The effects of a fault that the witness must know."""

    NONE = 0
    CUT = enum.auto()  # the robot cannot be reached
    FAILS = enum.auto()  # the robot's mission may fail
    CARRIES = enum.auto()  # the robot is not on its route


@dataclass(frozen=True)
class Fault:
    """A fault of a simulator.

    words    -- commands that make the simulator cause the fault; {goal} is a vertex or goal
    remedies -- commands that end the fault after some time
    effect   -- the effect on the robot, for the witness
    """

    words: Tuple[str, ...]
    remedies: Tuple[str, ...] = ()
    effect: Effect = Effect.NONE


AGV_FAULTS = (
    Fault(('stall 20',)),
    Fault(('slow 0.3',), ('slow 1',)),
    Fault(('silence',), ('silence 0',), Effect.CUT),
    Fault(('leave',), ('join',), Effect.CUT | Effect.FAILS),
    Fault(('fail',), (), Effect.FAILS),
    Fault(('takeover',), (), Effect.FAILS),
    Fault(('estop',), ('release',), Effect.FAILS),
    Fault(('offgraph 0.6',), (), Effect.FAILS | Effect.CARRIES),
    Fault(('place {goal}',), (), Effect.FAILS | Effect.CARRIES),
    Fault(('battery 60',), ('battery 95',)),
)
POWER = 'other enableMotors'
LD90_FAULTS = (
    Fault(('estop press',), ('estop release', POWER)),
    Fault(('motors off',), (POWER,), Effect.FAILS),
    Fault(('fail {goal}',), ('mend {goal}',), Effect.FAILS),
    Fault(('drop',), (), Effect.CUT),
    Fault(('reset',), (), Effect.CUT),
    Fault(('refuse on', 'drop'), ('refuse off',), Effect.CUT),
    Fault(('outgoing off',), ('outgoing on',), Effect.CUT),
    Fault(('silence 30',), (), Effect.CUT | Effect.FAILS),
    Fault(('delay 2',), ('delay 0',), Effect.CUT | Effect.FAILS),
    Fault(('halfline 3',), (), Effect.CUT),
    Fault(('reboot 20',), (POWER,), Effect.CUT | Effect.FAILS),
    Fault(('block',), ('unblock',), Effect.FAILS | Effect.CARRIES),
    Fault(('other goto {goal}',), ('other stop',), Effect.FAILS | Effect.CARRIES),
    Fault(('other stop',), (), Effect.FAILS),
    Fault(('lost 400 0 10',), ('other localizeToPoint {x} {y} {turn}',),
          Effect.FAILS | Effect.CARRIES),
    Fault(('prompt Who are you?', 'drop'), ('prompt', 'drop'), Effect.CUT),
    Fault(('dialect interrupted coordinates',), ('dialect interrupted name',), Effect.FAILS),
    Fault(('dialect help none', 'drop'), ('dialect help right', 'drop'), Effect.CUT),
    Fault(('autodock on',), ('autodock off',)),
    Fault(('battery 60',), ('battery 95',)),
)


class Disturbances:
    """Causes one disturbance after the other. Meanwhile a simulated person helps robots in need."""

    def __init__(self, hall: Hall, simulators: Simulators, fleet: Fleet, witness: Witness,
                 lock: threading.RLock, launch: Launch, master: RosMaster, speed: float,
                 seed: int, ended: threading.Event, site: SoakPlc) -> None:
        self._hall, self._simulators, self._fleet = hall, simulators, fleet
        self._witness, self._lock = witness, lock
        self._launch, self._master, self._speed = launch, master, speed
        self._site = site
        self._chance, self._ended = Random(seed), ended
        self._names = sorted(hall.radii)
        self._ld90s = [name for name in self._names if name.startswith('ld90')]
        self._held: Dict[str, int] = {}  # by robot: if above 0, no person helps it now
        self._refused: Dict[str, int] = {}  # by robot: consecutive refused joins
        self._carried_at: Dict[str, float] = {}
        self._turn = 0
        self.done: Dict[str, int] = {}
        self.notes: List[str] = []
        self.kinds: Dict[str, Callable[[], None]] = {
            'fault': self._fault, 'stop': self._stop, 'stop-and-kill': self._stop_and_kill,
            'stop-without-link': self._stop_without_link, 'out': self._out,
            'closure': self._closure, 'command': self._command, 'kill': self._kill,
            'plc': self._plc, 'door': self._door, 'press': self._press,
            'hang': self._hang, 'master': self._restart_master, 'quiet': self._quiet}
        self.weights = {'fault': 6, 'stop': 1, 'stop-and-kill': 1, 'stop-without-link': 1,
                        'out': 1, 'closure': 2, 'command': 4, 'kill': 2, 'hang': 2, 'master': 1,
                        'plc': 2, 'door': 2, 'press': 2,
                        'quiet': 1}

    def run(self, only: Sequence[str]) -> None:
        """Causes disturbances until `ended` is set. Completes each disturbance, and ends its fault.

        only -- the kinds of disturbances to cause; empty: all kinds
        """
        kinds = list(only) or list(self.kinds)
        while not self._ended.is_set():
            kind = self._chance.choices(kinds, [self.weights[one] for one in kinds])[0]
            try:
                self.kinds[kind]()
                self.done[kind] = self.done.get(kind, 0) + 1
            except (OSError, rosgraph.MasterException, xmlrpc.client.Error) as error:
                self.notes.append(f'{kind} failed: {error}')

    # -- robots ------------------------------------------------------------------------------------

    def _fault(self) -> None:
        name = self._chance.choice(self._names)
        table = LD90_FAULTS if name in self._ld90s else AGV_FAULTS
        fault = self._chance.choice(table)
        goal = self._free_vertex(name)
        with self._affected([name], fault.effect):
            self._inject(name, fault.words, goal)
            self._wait(self._chance.uniform(2.0, 8.0))
            self._inject(name, fault.remedies, goal)
            if Effect.CARRIES in fault.effect:
                self._wait(1.0)
        self.notes.append(f'{name}: {fault.words[0]}')

    def _inject(self, name: str, words: Sequence[str], goal: int) -> None:
        for one in words:
            x, y, turn = self._simulators.poses()[name]
            self._simulators.fault(name, one.format(
                goal=goal, x=round(1000 * x), y=round(1000 * y), turn=round(turn)))

    @contextmanager
    def _affected(self, names: Sequence[str], effect: Effect,
                  recovers: float = RECOVERS) -> Iterator[None]:
        now = time.monotonic()
        with self._lock:
            for name in names:
                if Effect.CARRIES in effect:
                    self._witness.carry(name, now)
                    self._held[name] = self._held.get(name, 0) + 1
                if effect & (Effect.FAILS | Effect.CARRIES):
                    self._witness.trouble(name, now)
            if Effect.CUT in effect:
                self._witness.cut(names)
        try:
            yield
        finally:
            if Effect.CUT in effect:
                time.sleep(recovers)
                with self._lock:
                    self._witness.mend(names, time.monotonic())
            with self._lock:
                for name in names:
                    if effect & (Effect.FAILS | Effect.CARRIES):
                        self._witness.trouble(name, time.monotonic())
                    if Effect.CARRIES in effect:
                        self._held[name] -= 1

    def _free_vertex(self, name: str) -> int:
        """Returns a random vertex that is far from all other robots."""
        poses = self._simulators.poses()
        places = list(self._hall.places.items())
        self._chance.shuffle(places)
        return next((id for id, place in places if all(
            math.dist(place, pose[:2]) > CLEAR for other, pose in poses.items()
            if other != name)), places[0][0])

    def _roomiest_vertex(self, name: str) -> int:
        """Returns the vertex that is farthest from its nearest robot; robot `name` does not count.
        """
        others = [pose[:2] for other, pose in self._simulators.poses().items() if other != name]
        return max(self._hall.places, key=lambda id: min(
            (math.dist(self._hall.places[id], place) for place in others), default=0.0))

    # -- people ------------------------------------------------------------------------------------

    def help_robots(self) -> None:
        """Acts as a person: lets each robot that needs help join the fleet.

        If a robot cannot join where it stands, the person first carries it to a vertex.
        """
        for name, told in self._fleet.robots().items():
            if (self._held.get(name) or told.state not in NEEDS_PERSON
                    or time.monotonic() < self._carried_at.get(name, -math.inf) + SETTLES):
                continue
            with self._lock:
                self._witness.trouble(name, time.monotonic())
            if self._fleet.call(f'/{name}/join_fleet'):
                self._refused[name] = 0
                with self._lock:
                    self._witness.bring_back(name)
                continue
            self._refused[name] = self._refused.get(name, 0) + 1
            x, y, _ = self._simulators.poses()[name]
            far = min(math.dist((x, y), place) for place in self._hall.places.values())
            if told.outage_code in (FleetRobot.OUTAGE_TOO_NEAR, FleetRobot.OUTAGE_OFF_GRAPH) or (
                    far > ON_GRAPH and told.state == FleetRobot.OFF_GRAPH) or (
                    self._refused[name] >= TRIES):
                self._carry_away(name)

    def _carry_away(self, name: str) -> None:
        goal = self._roomiest_vertex(name)
        self._carried_at[name] = time.monotonic()
        self._refused[name] = 0
        with self._lock:
            self._witness.carry(name, time.monotonic())
        if name in self._ld90s:
            x, y = self._hall.places[goal]
            self._inject(name, (f'push {round(1000 * x)} {round(1000 * y)}', POWER), goal)
        else:
            self._inject(name, (f'place {goal}',), goal)

    def remedy_all(self) -> None:
        """Ends all faults that robots may still have, opens all edges, and releases the fleet stop.
        """
        for name in self._names:
            table = LD90_FAULTS if name in self._ld90s else AGV_FAULTS
            for remedy in {words for fault in table for words in fault.remedies
                           if '{' not in words and 'other stop' not in words
                           and words not in ('drop', 'join')}:
                self._simulators.fault(name, remedy)
        self._fleet.edges(EdgeCommand.OPEN, sorted(self._hall.graph.edges))
        self._fleet.call('/resume_fleet')
        with self._lock:
            self._witness.release(self._names)

    def _out(self) -> None:
        name = self._chance.choice(self._names)
        with self._affected([name], Effect.FAILS):
            self._held[name] = self._held.get(name, 0) + 1
            if self._fleet.call(f'/{name}/leave_fleet'):
                with self._lock:
                    self._witness.stop([name], time.monotonic())
                self._wait(self._chance.uniform(8.0, 12.0))
            with self._lock:
                self._witness.release([name])
            self._held[name] -= 1

    def _closure(self) -> None:
        edges = self._chance.sample(sorted(self._hall.graph.edges), 2)
        self._fleet.edges(EdgeCommand.CLOSE, edges)
        self._wait(self._chance.uniform(5.0, 15.0))
        self._fleet.edges(EdgeCommand.OPEN, edges)

    def _command(self) -> None:
        with self._lock:
            missions = self._witness.open_missions
        if not missions:
            self._wait(1.0)
            return
        mission = self._chance.choice(missions)
        if self._chance.random() < 0.5:
            self._fleet.command(mission, MissionCommand.CANCEL)
        else:
            self._fleet.command(mission, MissionCommand.PAUSE)
            self._wait(self._chance.uniform(1.0, 6.0))
            for _ in range(3):  # a command may get lost if the process is killed
                self._fleet.command(mission, MissionCommand.RESUME)
                self._wait(0.5)
        self._wait(1.0)

    def _quiet(self) -> None:
        self._wait(10.0)

    # -- stops -------------------------------------------------------------------------------------

    def _stop(self) -> None:
        if self._is_stopped():
            self._wait(self._chance.uniform(9.0, 14.0))
        self._resume()

    def _stop_and_kill(self) -> None:
        """Kills the fleet manager during a fleet stop. After its restart the stop must still hold.
        """
        if self._is_stopped():
            with self._affected(self._names, Effect.CUT):
                self._kill_node('/path_supervisor')
            self._wait(12.0)
        self._resume()

    def _stop_without_link(self) -> None:
        """Stops the fleet while an LD-90 on a long route has no link, then restores the link.

        During this time all LD-90s are slow, so that the robot still drives when its link is back.
        A slow robot takes long to brake.
        """
        name = self._sent_far()
        if not name:
            return
        self._simulators.ld90_speed(SLOW)
        try:
            with self._affected([name], Effect.FAILS), \
                    self._affected(self._ld90s, Effect.CUT, BRAKES):
                self._inject(name, ('refuse on', 'drop'), 0)
                self._wait(1.0)
                if not self._is_stopped():
                    return
                if self._chance.random() < 0.5:
                    self._kill_node(f'/{name}/omron_controller')
                self._wait(0.5)
                self._inject(name, ('refuse off',), 0)
            self._wait(OWED)
        finally:
            self._simulators_allow(self._ld90s)
            self._simulators.ld90_speed(self._speed)
            self._resume()

    def _simulators_allow(self, names: Sequence[str]) -> None:
        for name in names:
            self._inject(name, ('refuse off',), 0)

    def _sent_far(self) -> str:
        """Sends an LD-90 across the hall. Returns its name when it drives; empty: none drives."""
        name = self._chance.choice(self._ld90s)
        start = self._simulators.poses()[name][:2]
        places = self._hall.places
        far = max(self._hall.stations, key=lambda id: math.dist(places[id], start))
        self._fleet.send([far], robot=name, priority=9)
        for _ in range(40):
            before = self._simulators.poses()[name][:2]
            self._wait(0.2)
            if math.dist(before, self._simulators.poses()[name][:2]) > 0.3:
                return name
        return ''

    def _is_stopped(self) -> bool:
        """Stops the fleet. Returns whether the fleet manager confirms the stop."""
        if not self._fleet.call('/stop_fleet'):
            return False
        with self._lock:
            self._witness.stop(self._names, time.monotonic())
        return True

    def _resume(self) -> None:
        with self._lock:
            self._witness.release(self._names)
        while not self._fleet.call('/resume_fleet') and self._launch.is_running:
            time.sleep(0.5)

    # -- programs ----------------------------------------------------------------------------------

    def _next_node(self) -> Tuple[str, List[str]]:
        """Returns the next node to disturb, and the robots that cannot be reached meanwhile."""
        nodes = [*((f'/{node}', self._names if node == 'path_supervisor' else [])
                   for node in MANAGER_NODES),
                 *((f'/{name}/{node}', [name]) for name in self._ld90s for node in LD90_NODES),
                 ('node_host', self._names)]
        self._turn += 1
        return nodes[(self._turn * 11) % len(nodes)]

    def _kill(self) -> None:
        node, robots = self._next_node()
        with self._affected(robots, Effect.CUT):
            if node == 'node_host':
                os.kill(self._launch.host(), signal.SIGKILL)
                self._wait(2.0)
            else:
                self._kill_node(node)
        self.notes.append(f'kill -9 {node}')

    def _kill_node(self, node: str) -> None:
        os.kill(process_of(node), signal.SIGKILL)

    def _hang(self) -> None:
        node, robots = self._next_node()
        process = self._launch.host() if node == 'node_host' else process_of(node)
        with self._affected(robots, Effect.CUT):
            os.kill(process, signal.SIGSTOP)
            try:
                self._wait(self._chance.uniform(2.0, 9.0))
            finally:
                os.kill(process, signal.SIGCONT)
        self.notes.append(f'SIGSTOP {node}')

    def _restart_master(self) -> None:
        with self._affected(self._names, Effect.CUT):
            self._master.kill()
            self._wait(self._chance.uniform(0.5, 4.0))
            self._master.start()
            self._wait(MASTER_RECOVERS)
        self.notes.append('ROS master restarted')

    # -- the PLC -----------------------------------------------------------------------------------

    def _plc(self) -> None:
        """Kills the PLC, if possible during a hand-over. After its restart, its memory is empty."""
        self._until(lambda: self._site.is_working)
        in_work = self._site.is_working
        self._site.kill()
        self._wait(self._chance.uniform(1.0, 8.0))
        self._site.start()
        self.notes.append(f'PLC dead{" in a hand-over" if in_work else ""}')

    def _door(self) -> None:
        """Closes the door, if possible while a robot claims it."""
        self._until(lambda: self._site.is_door_open)
        is_open, self._site.lies = self._site.is_door_open, True
        self._wait(self._chance.uniform(3.0, 12.0))
        self._site.lies = False
        self.notes.append(f'door shut{" on a claim" if is_open else ""}')

    def _press(self) -> None:
        """Breaks the press, so that each hand-over fails."""
        self._site.breaks = True
        self._until(lambda: self._site.is_working)
        self._wait(self._chance.uniform(4.0, 10.0))
        self._site.breaks = False
        self.notes.append('press broken')

    def _until(self, condition: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 15.0
        while not condition() and time.monotonic() < deadline and not self._ended.is_set():
            self._wait(0.1)

    def _wait(self, seconds: float) -> None:
        self._ended.wait(seconds)
