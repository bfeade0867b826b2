"""Commands about the connection itself."""
from __future__ import annotations

from omron_ld90_sim.interface.commands.table import CommandCall, CommandFailed, command, help_lines
from omron_ld90_sim.interface.configuration_table import OUTGOING


@command('help', 'gives the listing of available commands')
def show_help(call: CommandCall) -> None:
    """Prints the command list again."""
    for line in help_lines(call.server.dialect):
        call.reply(line)


@command('echo', 'with no args gets echo, with args sets echo', '[state]')
def echo(call: CommandCall) -> None:
    """Gets or sets whether the server echoes typed characters."""
    wanted = call.text.lower()
    if wanted in ('on', 'off'):
        call.session.echo = wanted == 'on'
        call.reply(f'Echo turned {wanted}.')
    elif wanted:
        call.reply('usage: echo <on/off>')
    else:
        call.reply('Echo is on.' if call.session.echo else 'Echo is off.')


@command('quit', 'closes this connection to the server')
def end_session(call: CommandCall) -> None:
    """Sends a farewell line and closes the connection."""
    call.reply('Closing connection')
    call.session.close()


@command('arclSendText', 'Sends the given message to all ARCL clients', '<string>', 1)
def send_text(call: CommandCall) -> None:
    """Sends a text unchanged to all clients."""
    call.server.broadcast(call.text)


@command('connectOutgoing', '(re)connects a socket to the given outside server',
         '<hostname> <port>', 2)
def connect_outgoing(call: CommandCall) -> None:
    """Moves the outgoing connection to another address; answers when it is open."""
    host, port = call.arguments[0], call.arguments[1]
    if not port.isdigit() or not 0 < int(port) < 65536:
        raise CommandFailed(f"Bad port '{port}'")
    settings = call.server.configuration
    settings.set(OUTGOING, 'OutgoingHostname', host)
    settings.set(OUTGOING, 'OutgoingPort', port)
    call.server.outgoing_asked = lambda: call.reply(f'Outgoing connected to {host} {port}')
    for session in list(call.server.sessions):
        if session.outgoing:
            session.close()


@command('shutDown', 'Shuts down the robot')
def shut_down(call: CommandCall) -> None:
    """Switches the robot off silently (ARCL manual I617-E-02 p. 240).

    The program keeps running without answering until it is ended.
    """
    call.server.switch_off()
