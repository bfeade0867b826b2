"""Commands that read and change the robot's configuration; every one needs `ArclConfig`."""
from __future__ import annotations

from functools import wraps

from omron_ld90_sim.commands.table import Call, CommandFailed, Handler, SetUpError, command
from omron_ld90_sim.configuration import FILES, SERVER, Parameter, Section

NOT_STARTED = 'You need to start a config before you can {} it.'


def _gated(handler: Handler) -> Handler:
    """Refuses the command unless `ArclConfig` is on."""
    @wraps(handler)
    def run(call: Call) -> None:
        if not call.server.configuration.flag(SERVER, 'ArclConfig'):
            raise CommandFailed('ArclConfig is off')
        handler(call)

    return run


def _section(call: Call) -> Section:
    section = call.server.configuration.sections.get(call.text)
    if section is None:
        raise CommandFailed(f'No section of name {call.text}')
    return section


@command('getConfigSectionList', 'Gets the list of config sections')
@_gated
def section_list(call: Call) -> None:
    """Lists the sections."""
    for name in call.server.configuration.sections:
        call.reply(f'GetConfigSectionList: {name}')
    call.reply('EndOfGetConfigSectionList')


@command('getConfigSectionValues', 'Gets the values of a config section', '<section>', 1)
@_gated
def section_values(call: Call) -> None:
    """Lists the values of one section; its name goes unquoted, in the right case."""
    for parameter in _section(call).parameters:
        call.reply(f'GetConfigSectionValue: {parameter.name} {parameter.value}'.rstrip())
    call.reply('EndOfGetConfigSectionValues')


@command('getConfigSectionInfo', 'Gets the information about a config section', '<section>', 1)
@_gated
def section_info(call: Call) -> None:
    """Describes one section and its parameters."""
    section = _section(call)
    call.reply(f'GetConfigSectionInfo: "{section.comment}" ""')
    for p in section.parameters:
        least, most = ('None' if bound is None else f'{bound:g}' for bound in (p.least, p.most))
        call.reply(f'GetConfigSectionParamInfo: {p.type} {p.name} {p.priority} {least} {most} '
                   f'"{p.description}" "{p.hint}" ""')
    call.reply('EndOfGetConfigSectionInfo')


@command('configStart', 'Starts importing config values. Use with configAdd and configParse.')
@_gated
def config_start(call: Call) -> None:
    """Begins an import."""
    call.server.configuration.start_import()
    call.reply('New config starting')


@command('configAdd', 'Adds a config file line to the config values being imported.',
         '<keyword> <value>', 1)
@_gated
def config_add(call: Call) -> None:
    """Adds `Section <name>` or `<parameter> <value>`."""
    key, _, value = call.rest.strip().partition(' ')
    if not call.server.configuration.add_to_import(key, value.strip()):
        raise SetUpError(NOT_STARTED.format('add to'))
    call.reply(f"Added '{call.rest.strip()}' to the config")


@command('configParse',
         'Parses the imported config values and terminates the configStart command.')
@_gated
def config_parse(call: Call) -> None:
    """Makes the changes, all of them or none."""
    result = call.server.configuration.finish_import()
    if result is None:
        raise SetUpError(NOT_STARTED.format('parse'))
    changes, errors = result
    call.reply('Will parse config')
    if not errors:
        try:
            for section, name, value in changes:
                if (section, name) == (FILES, 'Map'):
                    call.server.switch_map(value)
                else:
                    call.server.configuration.set(section, name, value)
            if any((section, name) != (FILES, 'Map') for section, name, _ in changes):
                call.server.broadcast('Configuration changed')
        except ValueError as error:
            errors = [str(error)]
    call.reply(f'Config had errors parsing: {"; ".join(errors)}' if errors
               else 'Config parsed fine')


@command('newConfigParam', 'Adds a new param to the config',
         '<section> <name> <description> <priority> <type> <default> <min> <max> <hint>', 6)
@_gated
def new_config_parameter(call: Call) -> None:
    """Adds a parameter; the robot keeps its value, not its definition, over a restart."""
    section, name, description, priority, kind, default = call.arguments[:6]
    bounds = [*call.arguments[6:8], 'None', 'None'][:2]
    hint = call.arguments[8] if len(call.arguments) > 8 else ''
    if kind not in ('string', 'int', 'double', 'bool'):
        raise CommandFailed(f"Bad type '{kind}'")
    try:
        least, most = (None if bound.lower() == 'none' else float(bound) for bound in bounds)
        parameter = Parameter(name, kind, default, description, least, most, priority, hint)
        parameter.check(default)
    except ValueError as error:
        raise CommandFailed(str(error)) from error
    sections = call.server.configuration.sections
    target = sections.setdefault(section, Section(''))
    if target.find(name) is None:
        target.parameters.append(parameter)
    call.reply(f"Will add new param '{name}' to section '{section}'")


@command('newConfigSectionComment', 'Adds a comment to a config section', '<section> <text>', 2)
@_gated
def new_section_comment(call: Call) -> None:
    """Gives a section its comment."""
    section, text = call.arguments[0], ' '.join(call.arguments[1:])
    call.server.configuration.sections.setdefault(section, Section('')).comment = text
    call.reply(f"Will add config comment '{text}' to section '{section}'")
