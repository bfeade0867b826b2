"""`ld90_sim`: a simulated LD-90 as a program."""
from __future__ import annotations

import argparse
import signal
import sys
from contextlib import ExitStack
from typing import Callable, List, Optional, Tuple, TypeVar

from omron_ld90_sim.interface.faults import help_text, run_script
from omron_ld90_sim.interface.fleet import RobotSpec, address, read_fleet
from omron_ld90_sim.interface.numbers import (
    number,
    percent,
    seconds,
    speed_factor,
    start_pose,
)
from omron_ld90_sim.interface.recording import read_log
from omron_ld90_sim.interface.simulator import ARRIVAL_ERROR, DEFAULT_LISTS, Replay, Simulator
from omron_ld90_sim.interface.transport import PortTaken
from omron_ld90_sim.motion.planner import NoWay
from omron_map import MapError, wait_for_map

_Value = TypeVar('_Value')


def _argument(read: Callable[[str], _Value]) -> Callable[[str], _Value]:
    """Wraps `read` for argparse, which shows only the text of its own error class."""
    def checked(text: str) -> _Value:
        try:
            return read(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from error

    return checked


def _port(text: str) -> int:
    if not text.isdigit() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"'{text}' is not a port from 0 to 65535")
    return int(text)


def _pose(text: str) -> Tuple[float, float, float]:
    try:
        return start_pose(*text.split(','))
    except (TypeError, ValueError):
        raise argparse.ArgumentTypeError(f"'{text}' is not X,Y,DEG (metres, metres, degrees)"
                                         ) from None


def _error(text: str) -> Tuple[float, float]:
    distance, _, turn = text.partition(',')
    try:
        return number(distance, 0.0, 100.0), number(turn, 0.0, 10.0)
    except ValueError:
        raise argparse.ArgumentTypeError(f"'{text}' is not MM,DEG (up to 100 mm and 10 degrees)"
                                         ) from None


def _list(text: str) -> Tuple[float, str]:
    interval, colon, commands = text.partition(':')
    try:
        return seconds(interval), commands if colon else ''
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"'{text}' is not SECONDS:COMMAND|COMMAND...") from None


def _setting(text: str) -> Tuple[str, str, str]:
    key, equals, value = text.partition('=')
    section, slash, name = key.rpartition('/')
    if not equals or not slash:
        raise argparse.ArgumentTypeError(f"'{text}' is not SECTION/PARAMETER=VALUE")
    return section, name, value


class _FaultHelp(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        print(help_text())
        parser.exit()


def parser() -> argparse.ArgumentParser:
    """Returns the command line."""
    result = argparse.ArgumentParser(
        prog='ld90_sim', usage='%(prog)s --map FILE [options]',
        description='A simulated OMRON LD-90 that speaks ARCL.')
    add = result.add_argument
    add('--map', metavar='FILE', help='.map file to drive on')
    add('--made-from', nargs='*', default=[], metavar='FILE',
        help='wait until the map is at least as new as these files')
    add('--port', type=_port, default=7171, help='ARCL port (7171); 0 chooses a free one')
    add('--host', default='127.0.0.1',
        help='address to listen on (127.0.0.1; 0.0.0.0 accepts other machines)')
    secret = result.add_mutually_exclusive_group()
    secret.add_argument('--password', help='ARCL password; the process list shows it')
    secret.add_argument('--password-file', metavar='FILE',
                        help='file that contains the ARCL password and nothing else')
    add('--outgoing', type=_argument(address), metavar='HOST:PORT',
        help='address to which the robot opens its outgoing connection')
    add('--outgoing-commands', type=_list, action='append', metavar='SECONDS:LIST',
        help='command list of the outgoing connection, commands separated by |, up to five '
             '(0.5:Status and 0.5:RangeDeviceGetCurrent Laser_1)')
    add('--set', type=_setting, action='append', default=[], metavar='SECTION/PARAMETER=VALUE',
        help='configuration of the robot, e.g. "Docking/AutoDock=true"')
    add('--speed', type=_argument(speed_factor), default=1.0,
        help="speed of the robot's whole clock as a factor, 0.1 to 20")
    add('--start', type=_pose, metavar='X,Y,DEG',
        help='start pose in metres and degrees (the dock, RobotHome, a goal, or a free place)')
    add('--battery', type=_argument(percent), default=100.0, metavar='PERCENT',
        help='state of charge (100)')
    add('--arrival-error', type=_error, default=ARRIVAL_ERROR, metavar='MM,DEG',
        help='largest distance from a goal at which the robot may stop (30,1); 0,0 is exact')
    add('--seed', type=int, default=0, help='seed of all random numbers (0)')
    add('--robots', metavar='FILE', help='YAML list of robots: a fleet in one process')
    add('--fleet-manager', type=_port, metavar='PORT',
        help='play an OMRON Fleet Manager on this port: it takes jobs for these robots; 0 chooses '
             'a free one')
    add('--fault', action='append', default=[], metavar='"[SECONDS] FAULT"',
        help='fault at that time or at once; --help-faults lists them')
    add('--fault-script', metavar='FILE', help='file with one such fault per line')
    add('--control', type=_port, metavar='PORT',
        help='accept faults on this port of 127.0.0.1, one per line')
    add('--log', metavar='FILE', help="write the (first) robot's sessions to FILE")
    add('--replay', metavar='LOG', help='play back a recorded session instead of a robot')
    add('--help-faults', action=_FaultHelp, nargs=0, help='list the faults and end')
    return result


def _password(arguments: argparse.Namespace) -> str:
    if arguments.password_file is None:
        return arguments.password or 'adept'
    with open(arguments.password_file, encoding='utf-8') as file:
        word = file.read().strip()
    if not word:
        raise ValueError(f'{arguments.password_file} is empty: write the ARCL password into it')
    return word


def _replay(arguments: argparse.Namespace) -> Replay:
    with open(arguments.replay, encoding='utf-8') as file:
        transfers = read_log(file.readlines())
    replay = Replay(transfers, arguments.port, arguments.outgoing, arguments.speed,
                    arguments.host)
    print(f'ready: ARCL on {arguments.host}:{replay.port}', flush=True)
    return replay


def _simulator(arguments: argparse.Namespace, stack: ExitStack) -> Simulator:
    if arguments.map is None:
        raise ValueError('no map is given: name a .map file with --map')
    if arguments.made_from:
        wait_for_map(arguments.map, made_from=arguments.made_from)
    specs: List[RobotSpec] = []
    if arguments.robots is not None:
        specs = read_fleet(arguments.robots)
    simulator = Simulator(
        arguments.map, arguments.port, _password(arguments), arguments.outgoing, arguments.speed,
        arguments.start, arguments.seed, arguments.host,
        (arguments.outgoing_commands or DEFAULT_LISTS)[:5], arguments.set, arguments.battery,
        specs, arguments.arrival_error)
    for fault in arguments.fault:
        simulator.inject(fault)
    if arguments.fault_script is not None:
        with open(arguments.fault_script, encoding='utf-8') as file:
            run_script(file, simulator.inject)
    if arguments.log is not None:
        file = open(arguments.log, 'w', encoding='ascii')   # noqa: SIM115 - closed by the stack
        simulator.log_to(stack.enter_context(file))
    if arguments.control is not None:
        print(f'faults on 127.0.0.1:{simulator.control_on(arguments.control)}', flush=True)
    if arguments.fleet_manager is not None:
        port = simulator.manage_on(arguments.fleet_manager, _password(arguments))
        print(f'Fleet Manager on {arguments.host}:{port}', flush=True)
    for name, port in simulator.ports.items():
        robot = f' ({name})' if specs else ''
        print(f'ready: ARCL on {arguments.host}:{port}{robot}', flush=True)
    return simulator


def main(argv: Optional[List[str]] = None) -> int:
    """Runs the program; returns 0 after a signal, 1 with one sentence if it cannot start."""
    given = sys.argv[1:] if argv is None else argv
    # roslaunch adds remappings such as __name:=ld90_sim, which have no meaning here
    words = [word for word in given if ':=' not in word]
    if '--start' in words[:-1]:     # argparse would take -1.0,2.0,90 for an option
        at = words.index('--start')
        words[at:at + 2] = [f'--start={words[at + 1]}']
    arguments = parser().parse_args(words)
    with ExitStack() as stack:
        try:
            program = (_replay(arguments) if arguments.replay is not None
                       else _simulator(arguments, stack))
        except (MapError, PortTaken, NoWay, ValueError) as error:
            print(f'ld90_sim: {error}', file=sys.stderr)
            return 1
        except OSError as error:
            print(f'ld90_sim: cannot open {error.filename}: {error.strerror}', file=sys.stderr)
            return 1
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda *_: program.stop())
        program.run()
    return 0
