"""Commands about the connection itself."""
from __future__ import annotations

from omron_ld90_sim.commands.table import Call, command, help_lines


@command('help', 'gives the listing of available commands')
def show_help(call: Call) -> None:
    """Prints the command list again."""
    for line in help_lines():
        call.reply(line)


@command('echo', 'with no args gets echo, with args sets echo', '[on|off]')
def echo(call: Call) -> None:
    """Gets or sets whether typed characters come back."""
    wanted = call.text.lower()
    if wanted in ('on', 'off'):
        call.session.echo = wanted == 'on'
        call.reply(f'Echo turned {wanted}.')
    elif wanted:
        call.reply('usage: echo <on/off>')
    else:
        call.reply('Echo is on.' if call.session.echo else 'Echo is off.')


@command('quit', 'closes this connection to the server')
def end_session(call: Call) -> None:
    """Says good-bye and closes."""
    call.reply('Closing connection')
    call.session.close()
