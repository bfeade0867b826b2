"""A witness that records commands and the knowledge of each giver, and finds broken rules."""
from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Callable, Dict, List, Optional, Sequence, Set, Tuple

from bridge_builders import yard
from delayed_drive import BRIDGE, PERSON, TICK, AnyRobot, DelayedDrive
from modelled_controller import Delays, ModelledController
from simulated_robot import SimulatedRobot

from omron_arcl import Execution, Giver, Outcome, Result
from omron_arcl.drives import LOOK, REFUSED, RETRY
from omron_arcl.execution import NO_GIVER
from omron_arcl.records import (
    CommandFate,
    Fate,
    LastCommand,
    MotionCause,
    MotionState,
    RecordKind,
    RobotMotion,
)
from omron_ld90.bridge import events as p

YARD = yard()
AT_ONCE = 1.0  # s in which commands of two clients may cross
LATE = 0.5  # s after the motors are enabled, within which the robot stops by itself
OBEYED_WITHIN = 6.0  # s within which the robot obeys a stop that has reached it, at any speed
SENT_WITHIN = LOOK + RETRY + 1.0  # s within which an owed stop is sent if the robot can be reached
TRUE_WITHIN = 6.0  # s within which the published state of a drive becomes true
GIVEN_WITHIN = 4.0  # s until the controller has the bridge's stop, if all links are connected


@dataclass(eq=False)
class Word:
    """A command that the controller took, or noticed from another client (`giver` None).

    Successive drives of one giver are one word.

    commands -- number of these commands that the robot has not refused
    """

    giver: Optional[Giver]
    drives: bool
    is_refused: bool = False
    commands: int = 1

    def refuse(self) -> None:
        """Notes that the robot refuses the command, so that it changes nothing."""
        self.drives, self.is_refused = False, True

    def refuse_one(self) -> None:
        """Notes that the robot refuses one of the commands."""
        self.commands -= 1
        if not self.commands:
            self.refuse()

    def is_drive_of(self, giver: Giver) -> bool:
        """Returns whether the command is a drive of this giver."""
        return self.drives and self.giver == giver


NO_WORD = Word(None, False)  # stands before the first command
REFUSED_OUTCOMES = (*REFUSED, Outcome.EMERGENCY_STOPPED)
# After one of these outcomes of a drive, the robot may still carry the drive out.
OPEN_OUTCOMES = (Outcome.LOST, Outcome.TIMED_OUT)


class WitnessedController(ModelledController):
    """A controller that reports each command it takes, and what the command's giver knew."""

    on_given: Callable[[str, Giver, int], None]
    given: List[Execution]
    on_answered: Callable[[str, float, Result], None]

    def give(self, command: str, giver: Giver, known_epoch: int,
             on_end: Callable[[Result], None], number: int = 0) -> Execution:
        """Gives the command as the base class does, and reports it."""
        before = word = self.last_word()
        commands, self.drove = word.commands, self.motion.memory.drives

        def end(result: Result) -> None:
            if result.outcome in REFUSED_OUTCOMES and is_counted:
                word.refuse_one()
            self.on_answered(command, now, result)
            on_end(result)
        now, is_counted = self._timeline.now, False
        execution = super().give(command, giver, known_epoch, end, number)
        word = self.last_word()
        is_counted = word is not before or word.commands != commands
        self.given.append(execution)
        self.on_given(command, giver, known_epoch)
        return execution

    def transmit(self, line: str) -> None:
        """Puts a line on its way as the base class does, and reports a stop."""
        if line == 'stop':
            self.on_stop_sent()
        super().transmit(line)

    last_word: Callable[[], Word]
    on_stop_sent: Callable[[], None]
    drove = False  # whether a drive, not a stop, was in force when the last command was given


class Witness(DelayedDrive):
    """A drive that a witness watches.

    dialect -- dialect of the simulated LD-90; empty: a `SpeakingRobot`, which is less like a real
        robot
    broken -- the violations that were found
    """

    def __init__(self, strategy: str, delays: Delays, interruption: str = '',
                 braking: float = 0.0, dialect: str = '') -> None:
        self.words: List[Word] = []
        # for each epoch, the last `Word` when the epoch was published
        self.words_of_epoch: Dict[int, Word] = {}
        # the published epochs, and those epochs of other givers that the bridge does not know yet
        self._epochs: List[int] = []
        self._foreign: Set[int] = set()
        # the epoch that the bridge reported when it learned of an epoch of others
        self._overruled_in = 0
        # for each stop on its way, the last `Word` when the stop was sent
        self._stops_sent: List[Word] = []
        self._stopped = NO_WORD  # this `Word` of the stop that arrived last
        # commands of other clients before a stop that has not reached the robot yet
        self._before_stops: List[Word] = []
        self.broken: List[str] = []
        self.lines: List[str] = []  # drives that reached the robot from the controller
        self.persons, self.came = '', False  # a person's last drive; whether it reached the robot
        self._taken: Counter[str] = Counter()    # number of drives with each text
        # number of these drives that reached the robot or were lost
        self._arrived: Counter[str] = Counter()
        self._is_number = 0  # a person's last drive: its number among drives with its text
        self._taken_at: List[float] = [-100.0]  # when the controller took drives and stops
        self.drives = 0  # number of drives that were taken
        self.foreign = False
        self._powered_at = -100.0
        # for each command text: when another client last gave it, or when a stall after it ended
        self._another_gave: Dict[str, float] = {}
        # when a drive of ours reached the robot just after another client's drive to the same goal
        self._mixed_up_at = -100.0
        self._stalls = 0.0  # time in s for which the link stalls after the robot's next line
        self._dialect = dialect
        # True until another client or a person acts, the controller restarts or its link is cut
        self.is_alone = True
        # since this time a stop is owed and the robot can be reached
        self._owed_since: Optional[float] = None
        self._stop_came_at = -100.0
        # since this time the robot drives although the last command is a stop
        self._disobeys_since: Optional[float] = None
        self._anothers = False  # whether the robot drives for another client
        self._began_unheard = False  # whether the controller missed the beginning of this drive
        self._unheard_until = -100.0  # until this time, no command reaches the controller
        self._forgotten: Set[int] = set()  # epochs of earlier controllers
        self._bridge_knows = NO_WORD  # the last `Word` of which the bridge knows
        # True from a stop of the fleet manager until the bridge has stopped the robot, or drives it
        self._is_ordered = False
        # the last `Word` that the bridge knew when it gave a stop, by process and number of a stop
        self._known_to_stops: Dict[Tuple[str, int], Word] = {}
        # the entry of `_known_to_stops` for the stop that arrives now
        self._known_to_stop: Optional[Word] = None
        # drives of givers other than the bridge; and for each epoch, how many of these drives the
        # robot had answered when the epoch was published
        self._others_drives: List[Execution] = []
        self._others_of_epoch: Dict[int, int] = {}
        # for a stop of the bridge, until the bridge drives: the last `Word` that it knew, and
        # the number of earlier drives of others
        self._demanded: Optional[Tuple[Word, int]] = None
        self._ignored_since: Optional[float] = None  # since this time the robot ignores this stop
        # for each number of a command of the bridge: the goal, or `stop`, and when it was taken
        self._sent_to: Dict[int, Tuple[str, float]] = {}
        self._driven_at = -100.0  # time of the last drive of any client
        self._arrived_at: Dict[str, float] = {}  # time of the last arrival at each goal
        self._heard_arrival_at: Dict[str, float] = {}  # when the controller heard of the arrival
        self._stood_at = -100.0
        self._given: List[Execution] = []  # drives and stops that have not reached the robot
        self._drives_of: Dict[Word, List[Execution]] = {}  # the drives of each `Word`
        # our drive that the robot carries out; None: it carries out none of ours
        self._obeyed: Optional[Execution] = None
        self._newest_drive: Optional[Execution] = None
        self._cancelled: List[Execution] = []  # drives that their own givers have cancelled
        # since this time the robot carries out a cancelled drive
        self._cancelled_since: Optional[float] = None
        # since this time the published state differs from what the robot does
        self._untrue_since: Optional[float] = None
        # since this time the robot drives for the bridge without a route
        self._routeless_since: Optional[float] = None
        # the last `Word` when another client acted during an outage, until the next status
        self._unheard: Optional[Word] = None
        super().__init__(YARD, 1, strategy, delays, interruption, braking)
        self._time.every(TICK, self._watch_owed_stop)
        self._time.every(TICK, self._watch_robot)
        self._time.every(TICK, self._watch_stop_of_bridge)
        self._time.every(TICK, self._watch_drive_without_route)
        self._time.every(TICK, self._watch_cancelled_drive)
        self._time.every(TICK, self._watch_what_is_told)

    _controller: WitnessedController

    def make_controller(self, delays: Delays) -> ModelledController:
        """Makes a controller that the witness watches."""
        controller = WitnessedController(self._time, delays, self._reach_robot, self._on_motion)
        controller.on_taken, controller.on_given = self._on_taken, self._on_given
        controller.last_word = lambda: self._last_word() or NO_WORD
        controller.on_stop_sent = lambda: self._stops_sent.append(self._newest_word)
        controller.given, controller.on_answered = self._given, self._judge_answer
        return controller

    def make_robot(self, vertex: int, interruption: str, braking: float) -> AnyRobot:
        """Makes the robot."""
        if not self._dialect:
            return super().make_robot(vertex, interruption, braking)
        return SimulatedRobot(vertex, self._say, lambda: self.now, self._dialect)

    @property
    def _newest_word(self) -> Word:
        return self.words[-1] if self.words else NO_WORD

    def _words_after(self, known: Word) -> Sequence[Word]:
        return self.words if known is NO_WORD else self.words[self.words.index(known) + 1:]

    def _on_given(self, command: str, giver: Giver, known_epoch: int) -> None:
        known = self.words_of_epoch.get(known_epoch)
        if command == 'stop':
            if known_epoch in self._forgotten:
                return
            if giver.name == BRIDGE:
                known = self._known_to_stop
            if known is not None:
                self._judge_stop(giver, known)
            return
        self._taken[command] += 1
        self._newest_drive = self._given[-1]
        self._drives_of.setdefault(self._newest_word, []).append(self._newest_drive)
        if giver.name != BRIDGE:
            self._others_drives.append(self._newest_drive)
        if giver == PERSON:
            self.persons, self.came, self._is_number = command, False, self._taken[command]
        passed = [word for word in self._words_after(known or NO_WORD)
                  if word.giver != giver and not word.is_refused]
        if known_epoch and (known is None or passed):
            self.broken.append(f'{giver.name} passed {passed}: {command}')

    def _last_word(self) -> Optional[Word]:
        return next((word for word in reversed(self.words) if not word.is_refused), None)

    def _on_taken(self, giver: Giver, drives: bool) -> None:
        last = self._last_word()
        if drives and last and last.is_drive_of(giver):
            last.commands += 1
        else:
            self.words.append(Word(giver, drives))
        self._taken_at.append(self.now)
        self.drives += drives

    def _judge_stop(self, giver: Giver, known: Word) -> None:
        """Checks that no stop ends an acknowledged drive that the giver of the stop does not know.
        The stop may end such a drive if another stop is on its way already.
        """
        records = self._controller.motion.memory.records
        pending = [record.giver for record in records if record.pending]
        last = next((word for word in self.words[-2::-1] if not word.is_refused), NO_WORD)
        if not self._controller.drove or last.is_drive_of(giver):  # the giver ends its own drive
            return
        unknown = [word for word in self._words_after(known)
                   if word.drives and word.giver not in (giver, None, *pending)]
        if unknown:
            self.broken.append(f'a stop of {giver.name} ended {unknown}')

    @property
    def is_heard(self) -> bool:
        """Whether commands reach the controller."""
        return self.now >= self._unheard_until

    def restart_controller(self, seconds: float = 0.0) -> None:
        """Kills the controller and starts it again.

        The new process receives commands only after some seconds, because topics and actions
        connect again one after the other.
        """
        if not self.spared and self._controller.connected:
            self._forgotten = set(self.words_of_epoch)
            self.is_alone = False
            self._unheard_until = self.now + seconds
        super().restart_controller()

    def order(self, route_id: int, *edges: int) -> None:
        """Sends a route as the base class does. A stop of the fleet manager may end any motion."""
        if self.bridge:
            self._is_ordered, self._demanded = self._is_ordered or not edges, None
        super().order(route_id, *edges)

    def _hear_motion(self, motion: RobotMotion, generation: int) -> None:
        if generation == self._generation:
            self._bridge_knows = self.words_of_epoch[motion.memory.epoch]
            self._note_told(motion)
        super()._hear_motion(motion, generation)

    def _note_told(self, motion: RobotMotion) -> None:
        """Notes that the bridge learns of an epoch, and so of all earlier epochs of others."""
        memory, bridge = motion.memory, self.bridge
        if bridge and memory.cause is not MotionCause.INTERRUPTED:  # the next epoch has the cause
            told = self._epochs[:self._epochs.index(memory.epoch) + 1]
            if bridge.robot.epoch and self._foreign.intersection(told):
                self._overruled_in = bridge.vehicle.state.epoch
            self._foreign.difference_update(told)

    def _give(self, give: p.Give) -> None:
        if give.command != 'stop':
            if self.bridge and self._overruled_in == self.bridge.vehicle.state.epoch:
                self.broken.append(f'{self.now:.1f} {give} passed an epoch of others: the fleet '
                                   'manager does not know of it')
            self._demanded, self._is_ordered = None, False
        else:
            if not self._is_ordered:
                self._known_to_stops[str(self._generation), give.number] = self._bridge_knows
            if self._demanded is None:
                epoch = give.known_epoch
                self._demanded = (self.words_of_epoch.get(epoch, self._newest_word),
                                  self._others_of_epoch.get(epoch, len(self._others_drives)))
        super()._give(give)

    def _take_from_bridge(self, give: p.Give, giver: Giver,
                          end: Callable[[Outcome, str], None]) -> None:
        def ended(outcome: Outcome, words: str) -> None:
            if give.command == 'stop' and outcome is Outcome.SUCCEEDED:
                self._is_ordered = False
            elif outcome is Outcome.OVERRULED:
                self._sent_to.pop(give.number, None)  # the command was never sent
            end(outcome, words)

        self._known_to_stop = self._known_to_stops.get((giver.process, give.number))
        if self.is_heard:
            if give.command != 'stop' or not self._anothers:  # the robot may drive on for others
                self._sent_to[give.number] = give.command.split()[-1], self.now
            super()._take_from_bridge(give, giver, ended)
        else:
            end(Outcome.NEVER_SENT, 'there is no controller')

    def cut(self, link: p.RobotLink, seconds: float) -> None:
        """Cuts a link as the base class does; messages on their way are lost."""
        if link is p.RobotLink.COMMANDS:
            self.is_alone = False
            self._arrived = Counter(self._taken)
            if self._obeyed and self._obeyed.command in [one.command for one in self._given]:
                self._obeyed = None  # a lost drive with the same text would look the same
            self._forget_lost_drives()
            self._given.clear()
            self._stops_sent.clear()
            if not self._seems_ours:
                for word in self._before_stops:  # the stops after these are lost
                    self.words.remove(word)
                    if self.robot.goal is None or self._anothers:  # otherwise it obeyed us later
                        self.words.append(word)
            self._before_stops.clear()
        super().cut(link, seconds)

    def _forget_lost_drives(self) -> None:
        """Marks lost drives as refused if the robot shows that it still obeys the earlier giver.

        Three conditions must hold: the robot carries out, or has completed, the drive of that
        giver; no command has stopped it; no lost drive leads to the goal that the robot shows.
        """
        goal = self.robot.status.split()[-1]
        for word, drives in self._drives_of.items():
            before = next((one for one in reversed(self.words[:self.words.index(word)])
                           if not one.is_refused), NO_WORD)
            goes_on = self._obeyed and word.giver != before.giver and before.is_drive_of(
                self._obeyed.giver)
            if goes_on and all(drive in self._given and drive.command.text.split()[-1] != goal
                               for drive in drives):
                word.refuse()

    def stall(self, seconds: float) -> None:
        """Holds back all lines on the link of commands for some seconds."""
        if not self.spared:
            self._note(f'stall of {seconds} s')
            crossing = [one for one in self._another_gave if self._crosses_anothers(one)]
            self._controller.stall(seconds)
            for command in crossing:
                self._another_gave[command] = self.now + self._controller.on_the_way(0.0)
            if self.now <= self._mixed_up_at + AT_ONCE:
                self._mixed_up_at = self.now + self._controller.on_the_way(0.0)

    def take_cancellation(self, canceller: Giver) -> None:
        """Cancels all commands on behalf of a giver."""
        if not self.is_heard:
            return
        self.words.append(Word(canceller, False))
        self._controller.cancel([one for one in self._drives if one.result is None], canceller)

    @property
    def open_drives(self) -> List[Execution]:
        """The drives of programs and people that have not ended for their givers."""
        return [drive for drive in self._others_drives if drive.result is None]

    def cancel_own(self, drive: Execution) -> None:
        """Cancels a drive on behalf of its giver. This is a stop unless there is a newer drive."""
        if not self.is_heard:
            return
        self._cancelled.append(drive)
        if drive is self._newest_drive:
            self.words.append(Word(drive.giver, False))
        self._controller.cancel_own(drive)

    def another_client(self, command: str, stalls: float = 0.0) -> None:
        """Gives a command as another client of the robot's server.

        stalls -- time in s for which the link holds back all lines of the answer except the first
        """
        self._stalls = stalls
        self.foreign, self.is_alone = True, False
        if command != 'stop':
            self._anothers, self._driven_at = True, self.now
            self._began_unheard = not self._controller.connected
        self._another_gave[command] = self.now + self._controller.on_the_way(0.0)
        if not self._controller.connected:
            self._unheard = self._newest_word
        self.robot.hear_another(command)
        self.foreign, self._obeyed, self._stalls = False, None, 0.0

    def _on_motion(self, motion: RobotMotion) -> None:
        if motion.memory.epoch not in self.words_of_epoch:
            ruling = motion.memory.ruling
            self._epochs.append(motion.memory.epoch)
            if motion.memory.cause is not MotionCause.RESTART and (
                    ruling is None or ruling.giver.name != BRIDGE):
                self._foreign.add(motion.memory.epoch)
        self.words_of_epoch.setdefault(motion.memory.epoch, self._newest_word)
        unanswered = sum(record.pending and record.giver.name != BRIDGE
                         for record in motion.memory.records)
        self._others_of_epoch.setdefault(motion.memory.epoch,
                                         len(self._others_drives) - unanswered)
        if self.is_alone and motion.memory.cause in (
                MotionCause.OTHER_CLIENT, MotionCause.ROBOT, MotionCause.INTERRUPTED):
            self.broken.append(f'there is no other client: {motion.memory.reason}')
        obeyed = [record.giver for record in motion.memory.records if not record.pending]
        if motion.memory.giver not in (NO_GIVER, *obeyed):
            self.broken.append(f'{motion.memory.giver.name} is told as the giver before the robot '
                               'has answered its drive')
        for last in motion.memory.last_commands:
            self._judge_last_command(last)
        super()._on_motion(motion)

    def _judge_last_command(self, last: LastCommand) -> None:
        """Checks that a drive is published as completed only if the robot has reached its goal."""
        goal, given_at = self._sent_to.get(last.number, ('stop', 0.0))
        if (last.fate is CommandFate.COMPLETED and goal != 'stop'
                and not self._was_done(goal, given_at)):
            self.broken.append(f'{self.now:.1f} {last} is told, but the robot is not at {goal}')

    def _judge_answer(self, command: str, given_at: float, result: Result) -> None:
        """Checks that the robot has carried out a successful command since it was given."""
        if result.outcome is Outcome.SUCCEEDED and not self._was_done(
                command.split()[-1], given_at):
            self.broken.append(f'{self.now:.1f} "{command}" is answered by {result}, but the robot '
                               f'shows {self.robot.status}')

    def _was_done(self, goal: str, since: float) -> bool:
        """Returns whether the robot is at the goal, or has reached it since `since`.

        For the goal `stop`, returns whether the robot stands, or has stood since `since`.
        """
        if goal == 'stop':
            # if two stops cross, it is unknown which one the robot answers; see `_reach_robot`
            crosses = max(self._another_gave.get('stop', -100.0) + AT_ONCE,
                          self._powered_at + LATE) >= since
            return self.robot.goal is None or self._stood_at >= since or crosses
        # if two drives to one goal cross, it is unknown which one the robot completes
        crosses = self._another_gave.get(f'goto {goal}', -100.0) + AT_ONCE >= since
        return (self._arrived_at.get(goal, -1.0) >= since
                or crosses and self._heard_arrival_at.get(goal, -1.0) >= since
                or self.robot.status.startswith((f'Arrived at {goal}', 'DockingState: Docked')))

    def _watch_what_is_told(self) -> None:
        """Checks `motion`, and the answer to the drive that the robot carries out."""
        untrue = self._what_is_told_wrongly() if self._can_be_reached else ''
        if not untrue:
            self._untrue_since = None
        elif self._untrue_since is None:
            self._untrue_since = self.now
        elif self.now > self._untrue_since + TRUE_WITHIN:
            self.broken.append(f'{self.now:.1f} {untrue}')

    def _what_is_told_wrongly(self) -> str:
        (memory, _, emergency_stop), drive = self._controller.motion, self._obeyed
        if emergency_stop is not self.robot.status.startswith('EStop'):
            return f'{emergency_stop} is told of the emergency stop at "{self.robot.status}"'
        under_way = self._controller.records._executions
        for record in memory.records:
            if record.pending and record.number not in under_way:
                return f'{record.words} is to be answered, but it is not under way'
        told, goal = '', self.robot.goal
        for last in memory.last_commands:
            command, given_at = self._sent_to.get(last.number, ('', 0.0))
            if (command == 'stop' and last.fate is CommandFate.NOT_OBEYED and goal is None
                    and self._driven_at < given_at < self._stood_at):
                return f'{last} is told of a stop, but the robot stands since'
        if (self._anothers and goal is not None and goal not in memory.names
                and not self._seems_to_dock
                and memory.giver != NO_GIVER and not memory.stop_owed):
            return f'{memory.giver.name} is told, but another client drives the robot to {goal}'
        if drive and goal is not None and not memory.stop_owed:
            if memory.giver not in (NO_GIVER, drive.giver):
                told = f'{memory.giver.name} is told as the giver'
            elif drive.result and drive.result.outcome not in OPEN_OUTCOMES:
                told = f'{drive.result} is told'
        return told and (f'{told}, but the robot carries out {drive.command.text} of '
                         f'{drive.giver.name}')

    def _say(self, line: str) -> None:
        """Sends a line of the robot.

        A command of another client, or an emergency stop, counts from the time at which the
        controller hears of it.
        """
        if line.startswith('Arrived at '):
            self._arrived_at[line.split()[-1]] = self.now
        elif line.startswith('DockingState: Docked'):
            self._arrived_at['dock'] = self.now
        seconds, arrives = self.delays.from_robot, self._controller.carry
        if line.startswith('Arrived at '):
            arrives(seconds, lambda: self._heard_arrival_at.update({line.split()[-1]: self.now}))
        if line == 'Stopped':  # if two stops cross, it is unknown which one this answers
            arrives(seconds, self._hear_stopped)
        if line == 'Motors enabled':
            arrives(seconds, self._hear_motors)
        if line.startswith('Status'):
            arrives(seconds, self._hear_status)
        stopped, said = self._stopped, self.now
        if line == 'EStop pressed' or self.foreign and line.startswith('Going to'):
            arrives(seconds, lambda: self._heard(line, stopped, said),
                    lambda: self._lost(line, stopped, said))
        elif self.foreign and line == 'Stopping':
            arrives(seconds, lambda: self._heard(line, stopped, said))
        elif self.foreign and line.startswith('Interrupted: '):
            drive = self._obeyed
            arrives(seconds, lambda: self._heard_broken_off(line, drive))
        super()._say(line)
        if self._stalls:
            self.stall(self._stalls)
            self._stalls = 0.0

    def _heard_broken_off(self, line: str, drive: Optional[Execution]) -> None:
        """Notes that the robot has broken off the drive in force, if the line names this drive."""
        record, = self._controller.motion.memory.records[-1:] or (None,)
        if (drive is not None and drive.result is None and record is not None
                and (record.kind, record.fate) == (RecordKind.DRIVE, Fate.OBEYED)
                and line == f'Interrupted: Going to {record.goal}'):
            self.words.append(Word(None, False))

    def _hear_stopped(self) -> None:
        self._stood_at = self.now

    def _hear_motors(self) -> None:
        self._powered_at = self.now

    def _hear_status(self) -> None:
        """Notes what another client did during an outage, if the status shows it.

        The status shows this if the robot carries out no drive of ours, does not stand because of
        our stop, and was given no command since.
        """
        before, self._unheard, status = self._unheard, None, self.robot.status
        last = self._last_word()
        if before is None or before is not self._newest_word or self._seems_ours or (
                self._seems_to_dock):
            return
        if status.startswith(('Going to', 'Arrived at')) or status == 'Stopped' and (
                last is None or last.drives):
            self.words.append(Word(None, self.robot.goal is not None))

    @property
    def _seems_ours(self) -> bool:
        """Whether the robot shows the goal of a drive of ours. Another client's drive to this goal
        looks the same.
        """
        return self.robot.status.split()[-1] in self._controller.motion.memory.names

    @property
    def _seems_to_dock(self) -> bool:
        """Whether the controller may take the drive of another client for a drive of ours to the
        dock: it has not heard the beginning, and some robots name their dock as a goal.
        """
        return (self._began_unheard and self.robot.status.startswith('Going to')
                and 'dock' in self._controller.motion.memory.names)

    def _heard(self, line: str, stopped: Word, said: float) -> None:
        """Notes another client's command, unless a command of ours has the same effect now.

        stopped -- value of `self._stopped` when the robot took the other client's command. All
            later stops of ours come after this command.
        said -- when the robot said the line; it may be heard much later
        """
        memory, state, _ = self._controller.motion
        if line == 'Stopping':
            crosses = any(abs(one - said) <= AT_ONCE for one in self._taken_at)
            is_clear = (not crosses and state is not MotionState.STOPPING
                        and self.now > max(self._taken_at[-1] + AT_ONCE, self._powered_at + LATE))
        elif line == 'EStop pressed':
            is_clear = True
        else:
            is_clear = line.split()[-1] not in memory.names
        if self._controller.connected and is_clear:
            word = Word(None, line.startswith('Going to'))
            if line != 'EStop pressed' and self._put_before_stops(word, stopped):
                return
            self.words.append(word)
            # a drive of ours that is on its way reaches the robot after the other client's drive
            pending = [record for record in memory.records if record.pending]
            self.words += [Word(record.giver, True) for record in pending[-1:] if word.drives]

    def _lost(self, line: str, stopped: Word, said: float) -> None:
        """Notes that the controller did not hear the line; a status may show the same later."""
        self._began_unheard = self._began_unheard or line.startswith('Going to')
        if self._is_shown(line) and not self._seems_to_dock:
            self._heard(line, stopped, said)

    def _is_shown(self, line: str) -> bool:
        """Returns whether the next status shows what a lost line said. This is not so if the robot
        has replaced the drive since.
        """
        return self.robot.status == line or (
            line == 'EStop pressed' and self.robot.status.startswith('EStop'))

    def _put_before_stops(self, word: Word, stopped: Word) -> bool:
        """Inserts another client's command before our first stop that the robot obeys later.

        Returns False if there is no such stop.
        """
        newest = (self._stops_sent or [self._stopped])[-1]
        after_newest = self._words_after(newest)
        stop = next((one for one in self._words_after(stopped) if one not in after_newest
                     and one.giver is not None and not (one.drives or one.is_refused)), None)
        if stop is None:
            return False
        self.words.insert(self.words.index(stop), word)
        if self._stops_sent:
            self._before_stops.append(word)
        return True

    def _reach_robot(self, line: str) -> None:
        if line == 'oneLineStatus':
            super()._reach_robot(line)
            return
        before = self.robot.goal, self.robot.status
        if line != 'stop':
            self.lines.append(line)
            self._driven_at = self.now
            # If two clients give the same command at nearly the same time, nothing shows which of
            # the two commands has taken effect.
            crosses = self._crosses_anothers(line)
            self._mixed_up_at = self.now if crosses else self._mixed_up_at
            self._arrived[line] += 1
            self.came = self.came or (
                line == self.persons and self._arrived[line] >= self._is_number)
        else:
            self._stop_came_at, self._stopped = self.now, self._stops_sent.pop(0)
            self._before_stops.clear()
            # Two cases are allowed. If another client's stop crosses a drive, the controller sends
            # a stop after the drive. If another client's drive seemed to be ours, then our stop
            # seems to come from the other client.
            crosses = (any(map(self._crosses_anothers, self._anothers_stops))
                       or self.now <= self._mixed_up_at + AT_ONCE)
            if (not crosses and self._controller.motion.memory.drives
                    and self._newest_word.is_drive_of(PERSON)
                    and self.came and self.persons == f'goto {self.robot.goal}'):
                self.broken.append(f'an older stop ended {self.persons} of a person')
        super()._reach_robot(line)
        self._note_obeyed(line)
        goal, status = self.robot.goal, self.robot.status
        if line != 'stop' and ((goal, status) != before or line.split()[-1] == goal):
            self._anothers = crosses  # otherwise the robot has refused the drive, and goes on

    def _note_obeyed(self, line: str) -> None:
        """Notes which drive the robot carries out now that it has received a line."""
        given = next((e for e in self._given if e.sent and e.command.text == line), None)
        if given is not None:
            self._given.remove(given)
        if self.robot.goal is None or any(
                self._crosses_anothers(command) for command in self._another_gave):
            # If two clients send drives to one goal at nearly the same time, nothing shows which of
            # the two drives the robot obeys.
            self._obeyed = None
        elif given is not None and line.split()[-1] == self.robot.goal:
            self._obeyed = given

    @property
    def _anothers_stops(self) -> Sequence[str]:
        """The other client's commands that the robot answers with `Stopping`."""
        return list(self._another_gave) if self._dialect == 'replacing stopping' else ['stop']

    def _crosses_anothers(self, command: str) -> bool:
        return self.now <= self._another_gave.get(command, -100.0) + AT_ONCE

    @property
    def _can_be_reached(self) -> bool:
        """Whether lines reach the robot now."""
        return self._controller.connected and not self._controller.is_stalled

    def _watch_robot(self) -> None:
        """Checks that the robot does not drive for us if our last command is a stop."""
        last = self._last_word()
        if (not self._can_be_reached or self._anothers or self.robot.goal is None
                or last is None or last.drives or last.giver is None):
            self._disobeys_since = None
        elif self._disobeys_since is None:
            self._disobeys_since = self.now
        elif self.now > self._disobeys_since + SENT_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot drives on after {last}')

    def _watch_stop_of_bridge(self) -> None:
        """Checks that the robot stands after a stop of the bridge, even if attempts have failed."""
        if (self._demanded is None or not self.is_well or not self.is_heard or self._anothers
                or not self._can_be_reached
                or self.robot.goal is None or self._came_later(*self._demanded)):
            self._ignored_since = None
        elif self._ignored_since is None:
            self._ignored_since = self.now
        elif self.now > self._ignored_since + SENT_WITHIN + GIVEN_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot drives on after a stop of the bridge')

    def _watch_drive_without_route(self) -> None:
        """Checks that the robot is stopped if it obeys a drive of a route that has ended."""
        if (self._obeyed is None or self._obeyed.giver.name != BRIDGE or self.robot.goal is None
                or not self.has_ended or not self.is_well or not self.is_heard
                or not (self._can_be_reached and self.hears_motions)):
            self._routeless_since = None
        elif self._routeless_since is None:
            self._routeless_since = self.now
        elif self.now > self._routeless_since + SENT_WITHIN + GIVEN_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot drives for a route that has ended')

    def _watch_cancelled_drive(self) -> None:
        """Checks that the robot is stopped if it carries out a drive that its giver cancelled."""
        if (self._obeyed not in self._cancelled or self.robot.goal is None
                or not self._can_be_reached):
            self._cancelled_since = None
        elif self._cancelled_since is None:
            self._cancelled_since = self.now
        elif self.now > self._cancelled_since + SENT_WITHIN:
            self.broken.append(f'{self.now:.1f} the robot carries out a cancelled drive')

    def _came_later(self, known: Word, drives: int) -> bool:
        """Returns whether the bridge gave its stop without knowledge of a drive that was given.

        Successive drives of one giver are one `Word`, but the later one may have begun an epoch.
        Therefore the drives of others are also counted.
        """
        return any(word.drives for word in self._words_after(known)) or any(
            drive.result is None or drive.result.outcome not in REFUSED_OUTCOMES
            for drive in self._others_drives[drives:])

    @property
    def owed_stop_waits(self) -> bool:
        """Whether a stop is owed, the robot stands, and it has not answered a drive that was given
        after this stop. This drive may make the stop needless.
        """
        memory = self._controller.motion.memory
        owed = max((record.number for record in memory.records if record.owed), default=0)
        return memory.stop_owed and self.robot.goal is None and any(
            record.pending and record.number > owed for record in memory.records)

    def _watch_owed_stop(self) -> None:
        memory = self._controller.motion.memory
        if (not (memory.stop_owed and self._can_be_reached) or memory.drives
                or self.owed_stop_waits):
            self._owed_since = None
            return
        if self._owed_since is None:
            self._owed_since = self.now
        # when the robot arrives for another client, the time limit for sending the stop starts anew
        arrived_at = max(self._heard_arrival_at.values(), default=-100.0) if self._anothers else 0.0
        waits_since = max(self._owed_since + SENT_WITHIN, self._stop_came_at + OBEYED_WITHIN,
                          arrived_at + SENT_WITHIN)
        if self.now > waits_since:
            self.broken.append(f'{self.now:.1f} an owed stop was not sent')
            self._owed_since = None
