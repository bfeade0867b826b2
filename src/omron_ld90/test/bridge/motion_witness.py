"""Notes by itself whose command the controller took, which giver knew of which, and what was
broken."""
from __future__ import annotations

from collections import Counter
from typing import Callable, Dict, List, NamedTuple, Optional, Set, Tuple

from bridge_builders import yard
from delayed_drive import BRIDGE, PERSON, TICK, AnyRobot, DelayedDrive
from modelled_controller import Delays, ModelledController
from simulated_robot import SimulatedRobot

from omron_arcl import Execution, Giver, Result
from omron_arcl.motion_authority import AT_ONCE, LATE, LOOK, RETRY, Motion, MotionState
from omron_ld90.bridge import events as p

YARD = yard()
OBEYED_WITHIN = 6.0  # s after a stop has come to the robot, at each speed
SENT_WITHIN = LOOK + RETRY + 1.0  # s that an owed stop may wait where the robot can be reached
GIVEN_WITHIN = 4.0  # s until the controller has a stop of the bridge, where all links stand


class Word(NamedTuple):
    """What the controller took, or heard that another client had done; `giver` None: that."""

    giver: Optional[Giver]
    drives: bool


class WitnessedController(ModelledController):
    """Tells of each command that it takes, with what its giver knew."""

    on_given: Callable[[str, Giver, int, int], None]

    def give(self, command: str, giver: Giver, known_epoch: int,
             on_end: Callable[[Result], None]) -> Execution:
        """As the base class does it."""
        words = self.count_words()
        execution = super().give(command, giver, known_epoch, on_end)
        self.on_given(command, giver, known_epoch, words)
        return execution

    count_words: Callable[[], int]


class Witness(DelayedDrive):
    """A drive under the eyes of a witness.

    robot -- a dialect of the simulator; empty: the model of a robot, which obeys more strangely
    broken -- what must not be
    """

    def __init__(self, strategy: str, delays: Delays, interruption: str = '',
                 braking: float = 0.0, dialect: str = '') -> None:
        self.words: List[Word] = []
        self.words_of_epoch: Dict[int, int] = {}  # so many had been taken when it was told
        self.broken: List[str] = []
        self.lines: List[str] = []  # drives that came to the robot from the controller
        self.persons, self.came = '', False  # last drive, and whether it came to the robot
        self._taken: Counter[str] = Counter()    # drives, by their text
        self._arrived: Counter[str] = Counter()  # of these, at the robot, or lost
        self._is_number = 0  # of the person's last drive among those of its text
        self.given_at = -100.0
        self.drives = 0  # that were taken
        self.foreign = False
        self._powered_at = -100.0
        self._another_gave = '', -100.0  # command of another client, and when it gave that
        self._dialect = dialect
        self._owed_since: Optional[float] = None  # a stop, and the robot can be reached
        self._stop_came_at = -100.0
        self._disobeys_since: Optional[float] = None  # it drives, although the last word is a stop
        self._anothers = False  # whether another client sent it where it drives
        self._unheard_until = -100.0  # nothing that is given comes to the controller until then
        self._forgotten: Set[int] = set()  # epochs of controllers before this one
        self._bridge_knows = 0  # so many words
        self._is_ordered = False  # whether the fleet manager itself wants the robot to stop
        self._known_to_stops: Dict[Tuple[str, int], int] = {}  # words, by process and number
        self._known_to_stop: Optional[int] = None  # the same, of the one that comes now
        self._demanded: Optional[int] = None  # words before the bridge's stop, until it drives
        self._ignored_since: Optional[float] = None  # that stop
        super().__init__(YARD, 1, strategy, delays, interruption, braking)
        self._time.every(TICK, self._watch_owed_stop)
        self._time.every(TICK, self._watch_robot)
        self._time.every(TICK, self._watch_stop_of_bridge)

    def make_controller(self, delays: Delays) -> ModelledController:
        """One that is witnessed."""
        controller = WitnessedController(self._time, delays, self._reach_robot, self._on_motion)
        controller.on_taken, controller.on_given = self._on_taken, self._on_given
        controller.count_words = lambda: len(self.words)
        return controller

    def make_robot(self, vertex: int, interruption: str, braking: float) -> AnyRobot:
        """The robot that is driven."""
        if not self._dialect:
            return super().make_robot(vertex, interruption, braking)
        return SimulatedRobot(vertex, self._say, lambda: self.now, self._dialect)

    def _on_given(self, command: str, giver: Giver, known_epoch: int, count: int) -> None:
        known = self.words_of_epoch.get(known_epoch)
        if command == 'stop':
            if known_epoch in self._forgotten:
                return
            if giver.name == BRIDGE:
                known = self._known_to_stop
            if known is not None:
                self._judge_stop(giver, known, count)
            return
        self._taken[command] += 1
        if giver == PERSON:
            self.persons, self.came, self._is_number = command, False, self._taken[command]
        if known_epoch and (
                known is None or any(word.giver != giver for word in self.words[known:count])):
            self.broken.append(f'{giver.name} passed {self.words[known or 0:count]}: {command}')

    def _on_taken(self, giver: Giver, drives: bool) -> None:
        if not (drives and self.words[-1:] == [Word(giver, True)]):  # else it just drives on
            self.words.append(Word(giver, drives))
        self.given_at, self.drives = self.now, self.drives + drives

    def _judge_stop(self, giver: Giver, known: int, count: int) -> None:
        """A stop may not end a drive of which its giver did not know."""
        unknown = [word for word in self.words[known:count]
                   if word.drives and word.giver not in (giver, None)]
        if unknown:
            self.broken.append(f'a stop of {giver.name} ended {unknown}')

    @property
    def is_heard(self) -> bool:
        """Whether what is given comes to the controller."""
        return self.now >= self._unheard_until

    def restart_controller(self, seconds: float = 0.0) -> None:
        """It dies, and is back; what is given comes to it after some seconds, as topics and
        actions are joined anew one by one."""
        if not self.spared and self._controller.connected:
            self._forgotten = set(self.words_of_epoch)
            self._unheard_until = self.now + seconds
        super().restart_controller()

    def order(self, route_id: int, *edges: int) -> None:
        """As the base class does it; a stop of the fleet manager ends each motion."""
        if self.bridge:
            self._is_ordered, self._demanded = not edges, None
        super().order(route_id, *edges)

    def _hear_motion(self, motion: Motion, generation: int) -> None:
        if generation == self._generation:
            self._bridge_knows = self.words_of_epoch[motion.memory.epoch]
        super()._hear_motion(motion, generation)

    def _give(self, give: p.Give) -> None:
        if give.command != 'stop':
            self._demanded = None
        else:
            if not self._is_ordered:
                self._known_to_stops[str(self._generation), give.number] = self._bridge_knows
            if self._demanded is None:
                self._demanded = self.words_of_epoch.get(give.known_epoch, len(self.words))
        super()._give(give)

    def _take_from_bridge(self, give: p.Give, giver: Giver,
                          end: Callable[[p.Ending, str], None]) -> None:
        self._known_to_stop = self._known_to_stops.get((giver.process, give.number))
        if self.is_heard:
            super()._take_from_bridge(give, giver, end)
        else:
            end(p.Ending.NEVER_SENT, 'there is no controller')

    def cut(self, link: p.Link, seconds: float) -> None:
        """As the base class does it; what is under way is lost."""
        if link is p.Link.COMMANDS:
            self._arrived = Counter(self._taken)
        super().cut(link, seconds)

    def take_cancellation(self, canceller: Giver) -> None:
        """A giver cancels everything."""
        if not self.is_heard:
            return
        self.words.append(Word(canceller, False))
        self._controller.cancel([one for one in self._drives if one.result is None], canceller)

    def another_client(self, command: str) -> None:
        """A client of the robot's own server."""
        self.foreign = True
        self._anothers = self._anothers or command != 'stop'
        self._another_gave = command, self.now
        self.robot.hear_another(command)
        self.foreign = False

    def _on_motion(self, motion: Motion) -> None:
        self.words_of_epoch.setdefault(motion.memory.epoch, len(self.words))
        super()._on_motion(motion)

    def _say(self, line: str) -> None:
        """The word of another client counts once the controller has heard of it.

        So does an emergency stop.
        """
        if line == 'Motors enabled':
            self.later(self.delays.from_robot, self._hear_motors)
        if line == 'EStop pressed' or self.foreign and (
                line == 'Stopping' or line.startswith('Going to')):
            self.later(self.delays.from_robot, lambda: self._heard(line))
        super()._say(line)

    def _hear_motors(self) -> None:
        self._powered_at = self.now

    def _heard(self, line: str) -> None:
        """A command beside one of ours with the same effect cannot be told from it."""
        memory, state = self._controller.motion
        if line == 'Stopping':
            is_clear = (self.now > max(self.given_at + AT_ONCE, self._powered_at + LATE)
                        and state is not MotionState.STOPPING)
        elif line == 'EStop pressed':
            is_clear = True
        else:
            is_clear = line.split()[-1] not in memory.goals
        if self._controller.connected and is_clear:
            self.words.append(Word(None, line.startswith('Going to')))

    def _reach_robot(self, line: str) -> None:
        if line == 'oneLineStatus':
            super()._reach_robot(line)
            return
        if line != 'stop':
            self.lines.append(line)
            command, given_at = self._another_gave
            # Two clients that give one command at one moment cannot be told apart.
            self._anothers = line == command and self.now <= given_at + AT_ONCE
            self._arrived[line] += 1
            self.came = self.came or (
                line == self.persons and self._arrived[line] >= self._is_number)
        else:
            self._stop_came_at = self.now
            if (self._controller.motion.memory.drives and self.words[-1:] == [Word(PERSON, True)]
                    and self.came and self.persons == f'goto {self.robot.goal}'):
                self.broken.append(f'an older stop ended {self.persons} of a person')
        super()._reach_robot(line)

    def _watch_robot(self) -> None:
        """In each belief of the controller: after a stop the robot drives nowhere for us."""
        if (not self._controller.connected or self._anothers or self.robot.goal is None
                or not self.words or self.words[-1].drives or self.words[-1].giver is None):
            self._disobeys_since = None
        elif self._disobeys_since is None:
            self._disobeys_since = self.now
        elif self.now > self._disobeys_since + SENT_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot drives on after {self.words[-1]}')

    def _watch_stop_of_bridge(self) -> None:
        """Also after failed tries the robot stands after a stop of the bridge."""
        if (self._demanded is None or not self.is_well or not self.is_heard or self._anothers
                or self.robot.goal is None
                or any(word.drives for word in self.words[self._demanded:])):
            self._ignored_since = None
        elif self._ignored_since is None:
            self._ignored_since = self.now
        elif self.now > self._ignored_since + SENT_WITHIN + GIVEN_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot drives on after a stop of the bridge')

    def _watch_owed_stop(self) -> None:
        memory = self._controller.motion.memory
        if not (memory.stop_owed and self._controller.connected) or memory.drives:
            self._owed_since = None
            return
        if self._owed_since is None:
            self._owed_since = self.now
        waits_since = max(self._owed_since + SENT_WITHIN, self._stop_came_at + OBEYED_WITHIN)
        if self.now > waits_since:
            self.broken.append(f'{self.now:.1f} an owed stop was not sent')
            self._owed_since = None
