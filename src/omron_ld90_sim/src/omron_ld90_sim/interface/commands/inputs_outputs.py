"""Digital inputs and outputs, analog inputs, sound, log and popup."""
from __future__ import annotations

from omron_ld90_sim.interface.commands.table import CommandCall, NotReady, command

_ON_OFF = {True: 'on', False: 'off'}
ANALOG_HELP = (     # ARCL manual I617-E-02 p. 54
    'List format is: <minV> <maxV> <maxRaw> <name>',
    'The data returned by analogInputQueryVoltage is a voltage as a double between <minV> and '
    '<maxV>',
    'The data returned by analogInputQueryRaw is an int called <rawValue>',
    "To get <rawValue> to voltage do '<minV> + (<maxV> - <minV>) * <rawValue> / <maxRaw>'",
)
SOUNDS = ('.wav', '.mp3', '.ogg')       # the suffixes that real robots' maps name for `play`
NO_SOUND = 'There was nothing given to replay.'


@command('inputList', 'Lists the named inputs')
def input_list(call: CommandCall) -> None:
    """Lists the digital inputs."""
    for name in call.robot.equipment.inputs:
        call.reply(f'InputList: {name}')
    call.reply('End of InputList')


@command('inputQuery', 'Queries the state of a named input', '<name>', 1)
def input_query(call: CommandCall) -> None:
    """Answers one digital input."""
    name = call.named(call.robot.equipment.inputs, 'input')
    call.reply(f'Input: {name} {_ON_OFF[call.robot.equipment.inputs[name]]}')


@command('outputList', 'Lists the named outputs')
def output_list(call: CommandCall) -> None:
    """Lists the digital outputs."""
    for name in call.robot.equipment.outputs:
        call.reply(f'OutputList: {name}')
    call.reply('End of OutputList')


@command('outputQuery', 'Queries the state of a named output', '<name>', 1)
def output_query(call: CommandCall) -> None:
    """Answers one digital output."""
    name = call.named(call.robot.equipment.outputs, 'output')
    call.reply(f'Output: {name} {_ON_OFF[call.robot.equipment.outputs[name]]}')


@command('outputOn', 'Turns on a named output', '<name>', 1)
def output_on(call: CommandCall) -> None:
    """Switches one digital output on."""
    call.robot.equipment.outputs[call.named(call.robot.equipment.outputs, 'output')] = True
    output_query(call)


@command('outputOff', 'Turns off a named output', '<name>', 1)
def output_off(call: CommandCall) -> None:
    """Switches one digital output off."""
    call.robot.equipment.outputs[call.named(call.robot.equipment.outputs, 'output')] = False
    output_query(call)


@command('analogInputList', 'Lists the named analog inputs')
def analog_input_list(call: CommandCall) -> None:
    """Lists the analog inputs with their ranges."""
    for line in ANALOG_HELP:
        call.reply(f'AnalogInputListHelper: {line}')
    for name, analog in call.robot.equipment.analog_inputs.items():
        call.reply(f'AnalogInputList: {analog.minimum:g} {analog.maximum:g} '
                   f'{analog.maximum_raw} {name}')
    call.reply('End of AnalogInputList')


@command('analogInputQueryRaw', 'Queries the state of an analog input by raw', '<name>', 1)
def analog_input_query_raw(call: CommandCall) -> None:
    """Answers one analog input in counts."""
    name = call.named(call.robot.equipment.analog_inputs, 'analog input')
    call.reply(f'AnalogInputRaw: {name} {call.robot.equipment.analog_inputs[name].raw}')


@command('analogInputQueryVoltage', 'Queries the state of an analog input by voltage', '<name>', 1)
def analog_input_query_voltage(call: CommandCall) -> None:
    """Answers one analog input in volts."""
    name = call.named(call.robot.equipment.analog_inputs, 'analog input')
    call.reply(f'AnalogInputVoltage: {name} {call.robot.equipment.analog_inputs[name].voltage:g}')


@command('say', 'Says the given text', '<text_string>', 1)
def say(call: CommandCall) -> None:
    """Speaks; the answer repeats the text as typed."""
    call.reply(f'Saying {call.rest.strip()}')


@command('play', 'Plays the given sound file', '<path_file>', 1)
def play(call: CommandCall) -> None:
    """Plays a sound file; this robot has every file with a known suffix."""
    if not call.text.lower().endswith(SOUNDS):
        raise NotReady(NO_SOUND)
    call.reply(f'Playing {call.text}')


@command('log', 'Logs the given message', '<message> [level]', 1)
def log(call: CommandCall) -> None:
    """Writes a message to the robot's own log."""
    words = call.rest.strip().split()
    level = 'Normal'
    if len(words) > 1 and words[-1].capitalize() in ('Terse', 'Normal', 'Verbose'):
        level = words.pop().capitalize()
    text = ' '.join(words).strip('"')
    call.reply(f"Logging '{text}' with level {level}")


@command('popupSimple', 'Creates a simple popup',
         '<"title"> <"message"> <"buttonLabel"> <timeout>', 4)
def popup_simple(call: CommandCall) -> None:
    """Shows a message in MobilePlanner, if there is one."""
    call.number(3)
    call.reply('Creating simple popup')
