"""Commands that read and change the robot's configuration; all of them need `ArclConfig`."""
from __future__ import annotations

from functools import wraps
from typing import Callable, List

from omron_ld90_sim.behaviour.robot import SimRobot
from omron_ld90_sim.interface.commands.table import (
    CommandCall,
    CommandFailed,
    Handler,
    NotReady,
    command,
)
from omron_ld90_sim.interface.configuration import (
    ADDED,
    FLAG,
    REAL,
    SEPARATOR,
    TEXT,
    WHOLE,
    Change,
    ConfigParameter,
    ConfigSection,
)
from omron_ld90_sim.interface.configuration_table import FILES, SERVER

NOT_STARTED = 'You need to start a config before you can {} it.'
MAP = (FILES, 'Map')
LOOK_EVERY = 0.1        # s between checks whether the robot is idle
TYPES = {'integer': WHOLE, 'int': WHOLE, 'double': REAL, 'string': TEXT, 'boolean': FLAG,
         'bool': FLAG, 'separator': SEPARATOR}      # the words of newConfigParam


def _gated(handler: Handler) -> Handler:
    """Refuses the command unless `ArclConfig` is on."""
    @wraps(handler)
    def run(call: CommandCall) -> None:
        if not call.server.configuration.flag(SERVER, 'ArclConfig'):
            raise CommandFailed('ArclConfig is off')
        handler(call)

    return run


def _section(call: CommandCall) -> ConfigSection:
    """Returns the section that the command names; case matters, and quotes are not removed."""
    name = call.rest.strip()
    section = call.server.configuration.sections.get(name)
    if section is None:
        raise CommandFailed(f'No section of name {name}')
    return section


def _own_section(call: CommandCall, name: str) -> ConfigSection:
    """Returns the section called `name`; adds it if there is none."""
    return call.server.configuration.sections.setdefault(name, ConfigSection('', flags=ADDED))


@command('getConfigSectionList', 'Gets the list of sections in the config')
@_gated
def section_list(call: CommandCall) -> None:
    """Lists the sections."""
    for name in call.server.configuration.sections:
        call.reply(f'GetConfigSectionList: {name}')
    call.reply('EndOfGetConfigSectionList')


@command('getConfigSectionValues', 'Gets the values in a section of the config', '<section>', 1)
@_gated
def section_values(call: CommandCall) -> None:
    """Lists the values of one section. The line of an empty value ends with the blank that
    separates it from the name, because clients split there.
    """
    for parameter in _section(call).parameters:
        call.reply(f'GetConfigSectionValue: {parameter.name} {parameter.value}')
    call.reply('EndOfGetConfigSectionValues')


@command('getConfigSectionInfo', 'Gets the info about a section of the config', '<section>', 1)
@_gated
def section_info(call: CommandCall) -> None:
    """Describes one section and its parameters."""
    section = _section(call)
    call.reply(f'GetConfigSectionInfo: "{section.comment}" "{section.flags}"')
    for parameter in section.parameters:
        call.reply(f'GetConfigSectionParamInfo: {parameter.info}')
    call.reply('EndOfGetConfigSectionInfo')


@command('configStart', 'Starts importing config values. Use with configAdd and configParse.')
@_gated
def config_start(call: CommandCall) -> None:
    """Begins an import."""
    call.server.configuration.start_import()
    call.reply('New config starting')


@command('configAdd', 'Adds a config file line to the config values being imported.',
         '<configuration> <value>', 1)
@_gated
def config_add(call: CommandCall) -> None:
    """Adds `Section <name>` or `<parameter> <value>`."""
    key, _, value = call.rest.strip().partition(' ')
    if not call.server.configuration.add_to_import(key, value.strip()):
        raise NotReady(NOT_STARTED.format('add to'))
    call.reply(f"Added '{call.rest.strip()}' to the config")


@command('configParse',
         'Parses the imported config values and terminates the configStart command.')
@_gated
def config_parse(call: CommandCall) -> None:
    """Makes all changes or none, as soon as the robot is idle."""
    result = call.server.configuration.finish_import()
    if result is None:
        raise NotReady(NOT_STARTED.format('parse'))
    changes, errors = result
    call.reply('Will parse config')
    if errors:
        call.reply(f'Config had errors parsing: {"; ".join(errors)}')
    else:
        _when_idle(call.robot, lambda: _change(call, changes))


def _when_idle(robot: SimRobot, action: Callable[[], None]) -> None:
    """Runs the action when the robot is idle and stands (ARCL manual I617-E-02 p. 46)."""
    if robot.activity is None and robot.base.still:
        action()
    else:
        robot.clock.after(LOOK_EVERY, lambda: _when_idle(robot, action))


def _change(call: CommandCall, changes: List[Change]) -> None:
    try:
        for _, _, value in (change for change in changes if change[:2] == MAP):
            call.server.switch_map(value)       # it may fail, so it comes before all other changes
    except ValueError as error:
        call.reply(f'Config had errors parsing: {error}')
        return
    for change in (change for change in changes if change[:2] != MAP):
        call.server.configuration.set(*change)
    if changes:         # also after `Map changed`: public client programs wait for it
        call.server.broadcast('Configuration changed')
    call.reply('Config parsed fine')


@command('newConfigParam', 'Adds a new param to the config',
         '<section> <name> <description> <priority_level> <type> <default_value> <min> <max> '
         '<DisplayHint>', 9)
@_gated
def new_config_parameter(call: CommandCall) -> None:
    """Adds a parameter; after a restart the robot keeps its value, but not its definition."""
    section, name, description, priority, kind, default, low, high, hint = call.arguments[:9]
    if kind.lower() not in TYPES:
        raise CommandFailed(f"Bad type '{kind}'")
    try:
        minimum, maximum = (None if bound.lower() == 'none' else float(bound)
                            for bound in (low, high))
        parameter = ConfigParameter(name, TYPES[kind.lower()], default, description, minimum,
                                    maximum, priority, '' if hint.lower() == 'none' else hint)
        parameter.check(default)
    except ValueError as error:
        raise CommandFailed(str(error)) from error
    target = _own_section(call, section)
    if target.find(name) is None:
        target.parameters.append(parameter)
    call.reply(f"Will add new param '{name}' to section '{section}'")


@command('newConfigSectionComment', 'Adds a comment to a config section', '<section> <comment>', 2)
@_gated
def new_section_comment(call: CommandCall) -> None:
    """Gives a section its comment."""
    section, text = call.arguments[0], ' '.join(call.arguments[1:])
    _own_section(call, section).comment = text
    call.reply(f"Will add config comment '{text}' to section '{section}'")
