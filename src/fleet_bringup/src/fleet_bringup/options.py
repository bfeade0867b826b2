"""The arguments of `scripts/run.sh fleet:=...`, written `name:=value`."""
from __future__ import annotations

import difflib
import os
from dataclasses import dataclass, field, fields
from typing import Any, Dict, Sequence, get_type_hints

from fleet_bringup.errors import CannotStart


def _option(default: Any, doc: str) -> Any:
    return field(default=default, metadata={'doc': doc})


@dataclass(frozen=True)
class Options:
    """The options of a start. An empty file name stands for the file of the laboratory.

    Each attribute is an option.
    """

    fleet: str = _option('', 'N: N simulated LD-90s and N simulated AGVs; FILE: a fleet file')
    graph_file: str = _option('', 'trajectory graph (YAML); empty: the laboratory')
    work_file: str = _option('', 'work file (YAML): stations, devices, templates, timetables')
    work: bool = _option(False, 'true: the laboratory\'s work file, its simulated doors, and a '
                                'simulated PLC that hands loads over')
    base_map: str = _option('', '.map file from which, with the graph, the LD-90s\' map is made')
    map_file: str = _option('', 'instead of base_map: finished .map file, with a goal per vertex')
    longest_edge: float = _option(0.0, 'm; longer edges are divided into sections; 0: no edge is')
    sim_speed: float = _option(1.0, 'factor on the clock of all simulated robots, 0.1 to 20')
    demo: bool = _option(False, 'true: send random missions')
    lasers: bool = _option(False, 'true: the simulated LD-90s also send their laser')
    rviz: bool = _option(bool(os.environ.get('DISPLAY')), 'true: open RViz')
    page: bool = _option(True, 'true: show the fleet in browsers, with the fleet manager')
    page_port: int = _option(8080, 'port of the page')
    listen: str = _option('127.0.0.1', 'address at which browsers reach the page; another one '
                                       'needs token_file')
    token_file: str = _option('', 'file with the tokens of the roles see, operate and admin')
    certificate_file: str = _option('', 'PEM file; with key_file, the page is served by TLS')
    key_file: str = _option('', 'PEM file')
    strategy: str = _option('rolling', 'strategy by which LD-90s drive routes')
    fleet_manager: bool = _option(True, 'false: start the robots only')
    hosted: bool = _option(True, 'false: each node is a process of its own, which needs three '
                                 'times the memory')
    arcl_port: int = _option(7171, 'ARCL port of the first simulated LD-90; add 10 for each next')
    outgoing_port: int = _option(7179, 'port of this computer to which the first LD-90 connects; '
                                       'add 10 for each next')
    control_port: int = _option(7160, 'port for faults and true poses of the simulated LD-90s; '
                                      'that of the AGVs is 1 higher')


def parse(words: Sequence[str], folder: str = '') -> Options:
    """Returns the options from arguments `name:=value`; raises CannotStart.

    folder -- folder of relative file names; empty: the working directory
    """
    types = get_type_hints(Options)
    given: Dict[str, Any] = {}
    for word in words:
        name, assigned, value = word.partition(':=')
        if not assigned:
            raise CannotStart(f"'{word}' is not of the form name:=value.")
        if name not in types:
            near = difflib.get_close_matches(name, types, 1)
            meant = f'did you mean {near[0]}?' if near else f'there are: {", ".join(types)}.'
            raise CannotStart(f"There is no argument '{name}' with fleet:=; {meant}")
        given[name] = _value(name, types[name], value, folder)
    options = Options(**given)
    if not options.fleet:
        raise CannotStart('fleet:= is missing: give fleet:=4, or fleet:=FILE with a fleet file.')
    if not 0.1 <= options.sim_speed <= 20.0:
        raise CannotStart(f'sim_speed:={options.sim_speed:g} must lie in 0.1 to 20.')
    if not 0.0 <= options.longest_edge <= 1000.0 or 0.0 < options.longest_edge < 0.5:
        raise CannotStart(f'longest_edge:={options.longest_edge:g} must be 0.5 m or more, or 0.')
    if options.base_map and options.map_file:
        raise CannotStart('Both base_map:= and map_file:= are given: give only one of them.')
    if options.work and (options.work_file or options.graph_file):
        raise CannotStart('work:=true is the work of the laboratory: leave out work_file:= and '
                          'graph_file:=, or give work_file:= without work:=true.')
    return options


def help_text() -> str:
    """Returns the help text: all arguments, one per line."""
    return '\n'.join(f'  {one.name}:=  {one.metadata["doc"]}'
                     + (f' ({one.default})' if one.default not in ('',) else '')
                     for one in fields(Options))


def _value(name: str, kind: type, text: str, folder: str) -> Any:
    try:
        if kind is bool:
            return {'true': True, '1': True, 'false': False, '0': False}[text.lower()]
        if kind is int:
            port = int(text)
            if not 0 < port < 65536:
                raise ValueError
            return port
        if kind is float:
            return float(text)
    except (KeyError, ValueError):
        what = {bool: 'true or false', int: 'a TCP port from 1 to 65535', float: 'a number'}[kind]
        raise CannotStart(f'{name}:={text} must be {what}.') from None
    is_file = name.endswith(('_file', '_map')) or (name == 'fleet' and not text.isdigit())
    if is_file and text:
        return os.path.abspath(os.path.join(folder, os.path.expanduser(text)))
    return text
