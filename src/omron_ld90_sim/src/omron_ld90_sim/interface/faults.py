"""Faults on demand: each is one line of words; the words are the same in all interfaces.

They come from `--fault`, from a script file (`[SECONDS] FAULT` per line, `#` comments), from the
control socket and from `Simulator.inject`. Without a request there are no faults.
"""
from __future__ import annotations

import inspect
import sys
from typing import Callable, Dict, Iterable, Tuple

from omron_ld90_sim.behaviour import activities
from omron_ld90_sim.behaviour.task import find_goal
from omron_ld90_sim.interface import numbers
from omron_ld90_sim.interface.configuration_table import DOCKING
from omron_ld90_sim.interface.dialect import PROMPT, SWITCHES
from omron_ld90_sim.interface.server import ArclServer
from omron_ld90_sim.interface.session import SimSession
from omron_ld90_sim.motion.kinematics import SimPose
from omron_ld90_sim.motion.space import Disc

BLOCK_AHEAD = 1500.0        # mm in front of the robot at which `block` places its obstacle
BLOCK_RADIUS = 300.0
LARGEST_BLOCK = 10_000.0    # mm


class NoSuchFault(ValueError):
    """The words name no fault, or contain wrong numbers."""


class Faults:
    """Applies faults to one robot. Each public method applies the fault of its name.

    The first line of a method's docstring is its usage, the rest its meaning (`--help-faults`).

    The class has many methods because there is one for each fault.
    """

    def __init__(self, server: ArclServer) -> None:
        self._server, self._robot = server, server.robot
        self._other = SimSession(server, -1, outgoing=True)

    def inject(self, words: str) -> None:
        """Applies one fault; raises `NoSuchFault` if the words name none."""
        name, *arguments = words.split() or ['']
        method = _method(name)
        try:
            inspect.signature(method).bind(self, *arguments)
        except TypeError as error:
            raise NoSuchFault(f"'{words}' is no fault, expected: {_usage(method)}") from error
        try:
            method(self, *arguments)
        except (ValueError, KeyError) as error:
            reason = f' ({error})' if isinstance(error, ValueError) else ''
            raise NoSuchFault(
                f"'{words}' is no fault, expected: {_usage(method)}{reason}") from error

    def schedule(self, line: str) -> None:
        """Applies a fault `[SECONDS] FAULT` when the clock shows SECONDS; without SECONDS, now."""
        first, _, rest = line.strip().partition(' ')
        try:
            float(first)
        except ValueError:
            self.inject(line)
            return
        try:
            seconds = numbers.seconds(first)
        except ValueError as error:
            raise NoSuchFault(f"'{line}' has no time ({error})") from error
        _method(*rest.split()[:1])

        def later() -> None:
            try:
                self.inject(rest)
            except NoSuchFault as error:   # no client waits for an answer now
                print(f'ld90_sim: {error}', file=sys.stderr)

        self._server.clock.at(seconds, later)

    # -- the robot -----------------------------------------------------------------------------

    def estop(self, action: str) -> None:
        """estop press|release

        The emergency stop button; after its release the motors stay off until enableMotors.
        """
        permission = self._robot.permission
        {'press': permission.press_estop, 'release': permission.release_estop}[action]()

    def motors(self, action: str) -> None:
        """motors off

        Motors off without the emergency stop; enableMotors switches them on.
        """
        {'off': lambda: self._robot.permission.cut_motors()}[action]()

    def push(self, x: str, y: str, turn: str = '') -> None:
        """push X_MM Y_MM [HEADING_DEG]

        A person pushes the robot there with motors off; enableMotors switches them on.
        """
        heading = numbers.angle(turn) if turn else self._robot.true_pose.theta
        self._robot.push(SimPose(numbers.length(x), numbers.length(y), heading))

    def lost(self, dx: str = '3000', dy: str = '0', turn: str = '90') -> None:
        """lost [DX_MM DY_MM TURN_DEG]

        The robot believes that it is somewhere else, until localizeToPoint corrects it.
        """
        self._robot.lose(SimPose(numbers.length(dx), numbers.length(dy), numbers.angle(turn)))

    def block(self, x: str = '', y: str = '', radius: str = str(BLOCK_RADIUS)) -> None:
        """block [X_MM Y_MM [RADIUS_MM]]

        A round obstacle that is not on the map; without arguments 1.5 m ahead on the robot's way.
        """
        size = numbers.number(radius, 1.0, LARGEST_BLOCK)
        if x:
            place = SimPose(numbers.length(x), numbers.length(y), 0.0)
        else:
            track = self._robot.base.track
            place = (track.pose_at(min(self._robot.base.place + BLOCK_AHEAD, track.length))
                     if track else self._robot.true_pose.ahead(BLOCK_AHEAD))
        self._robot.navigation.blocks.append(Disc(place.x, place.y, size))

    def unblock(self) -> None:
        """unblock

        Removes all obstacles of `block`.
        """
        self._robot.navigation.blocks.clear()

    def fail(self, *goal: str) -> None:
        """fail GOAL

        The next drives to that goal end in `Error: Failed going to goal`; see mend.
        """
        self._robot.quirks.failing_goals.add(_name(goal))

    def mend(self, *goal: str) -> None:
        """mend GOAL

        The goal can be reached again.
        """
        self._robot.quirks.failing_goals.discard(_name(goal))

    def faildock(self, times: str = '1') -> None:
        """faildock [TIMES]

        The next TIMES drives into a dock miss the charger: the robot backs out and retries.
        """
        self._robot.quirks.failing_docks = int(numbers.number(times, 0, 100))

    def battery(self, percent: str) -> None:
        """battery PERCENT

        Sets the state of charge; at 0 the robot shuts down until it is charged and rebooted.
        """
        self._robot.docking.update()
        self._robot.docking.battery.percent = numbers.percent(percent)

    def other(self, *command: str) -> None:
        """other COMMAND

        Another client, which is not visible, sends this ARCL command, e.g. `other goto 12`.
        """
        if not command:
            raise ValueError('no command')
        self._server.execute(self._other, ' '.join(command))
        self._other.output.clear()

    def park(self, *goal: str) -> None:
        """park GOAL

        The robot drives to that goal by itself: `Parking`, then `Parked`.
        """
        found = find_goal(self._robot.document, _name(goal))
        if found is None:
            raise ValueError('there is no such goal')
        self._robot.start(activities.park(self._robot, found))

    def autodock(self, action: str) -> None:
        """autodock on|off

        The robot docks by itself when its battery is low or it has been idle for long.
        """
        value = {'on': 'true', 'off': 'false'}[action]
        self._server.configuration.set(DOCKING, 'AutoDock', value)

    # -- the network ---------------------------------------------------------------------------

    def refuse(self, action: str) -> None:
        """refuse on|off

        New connections are refused; existing ones continue.
        """
        self._server.accepting = {'on': False, 'off': True}[action]

    def drop(self) -> None:
        """drop

        Closes every connection.
        """
        self._server.drop_all()

    def reset(self) -> None:
        """reset

        Ends every connection with RST.
        """
        self._server.drop_all(abort=True)

    def prompt(self, *text: str) -> None:
        """prompt [TEXT]

        Changes the prompt for new clients; without a text it restores the right prompt.
        """
        self._server.dialect.prompt = (' '.join(text) or PROMPT).encode() + b'\r\n'

    def dialect(self, what: str, *value: str) -> None:
        """dialect WHAT VALUE

        Changes to the dialect of a less exact robot: prompt TEXT (without a line end),
        welcome [TEXT], help left|names|none|right, unlisted COMMAND..., missing COMMAND...,
        encoding raw|ascii|latin-1, goals quoted|plain, interrupted name|coordinates|nothing,
        replacing stopping|silent, unknown bare|named, battery volts|percent, status older|newer.
        """
        SWITCHES[what](self._server.dialect, self._robot, ' '.join(value))

    def silence(self, seconds: str) -> None:
        """silence SECONDS

        Nothing is sent for this time; then all lines come at once.
        """
        self._server.impairment.silent_until = self._server.clock.now + numbers.seconds(seconds)

    def delay(self, seconds: str) -> None:
        """delay SECONDS

        Every line is sent this much later; 0 ends the delay.
        """
        self._server.impairment.delay = numbers.seconds(seconds)

    def halfline(self, seconds: str = '1') -> None:
        """halfline [SECONDS]

        The next line is cut in two; its second half is sent this much later.
        """
        self._server.impairment.half_line = numbers.seconds(seconds)

    def reboot(self, seconds: str = '5') -> None:
        """reboot [SECONDS]

        The robot's computer is gone for this time: no port, no connection, no activity.
        """
        self._server.restart(numbers.seconds(seconds), abort=True)

    def outgoing(self, action: str) -> None:
        """outgoing on|off

        Cuts the outgoing connection and prevents a new one, or allows it again.
        """
        self._server.outgoing_wanted = {'on': True, 'off': False}[action]
        for session in list(self._server.sessions):
            if session.outgoing and not self._server.outgoing_wanted:
                session.close()


def run_script(lines: Iterable[str], schedule: Callable[[str], None]) -> None:
    """Schedules every line of a script. Raises `NoSuchFault`, with the number of the wrong line."""
    for count, line in enumerate(lines, 1):
        line = line.partition('#')[0].strip()
        if line:
            try:
                schedule(line)
            except NoSuchFault as error:
                raise NoSuchFault(f'line {count}: {error}') from error


def _name(words: Tuple[str, ...]) -> str:
    if not words:
        raise ValueError('no goal')
    return ' '.join(words).strip('"').lower()


def _methods() -> Dict[str, Callable[..., None]]:
    others = ('inject', 'schedule')
    return {name: method for name, method in vars(Faults).items()
            if not name.startswith('_') and name not in others and inspect.isfunction(method)}


def _method(name: str = '') -> Callable[..., None]:
    method = _methods().get(name.lower())
    if method is None:
        raise NoSuchFault(f"no fault '{name}': --help-faults lists them")
    return method


def _usage(method: Callable[..., None]) -> str:
    return (inspect.getdoc(method) or '').splitlines()[0]


def help_text() -> str:
    """Returns the usage and meaning of all faults, one line each."""
    paragraphs = []
    for _, method in sorted(_methods().items()):
        usage, *meaning = (inspect.getdoc(method) or '').splitlines()
        paragraphs.append('  '.join([f'{usage:<34}', ' '.join(meaning).strip()]))
    return '\n'.join(paragraphs)
