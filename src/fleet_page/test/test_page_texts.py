"""Each text of the page is in both language tables, and the page loads no files of other sites."""
import ast
import gzip
import json
import re
from pathlib import Path

import pytest
from page_builders import PAGE_FOLDER

from fleet_core.interlocking.resources import ResourceKind
from fleet_core.supervision.fleet_view import ASKS, LOAD_MOVES, LOAD_WORDS, WORKING, RobotState
from fleet_core.supervision.looks import DEVICE_WORDS, QueueState
from fleet_core.supervision.machine_view import MachineState
from fleet_core.supervision.outages import Outage
from fleet_page.core.acts import ANSWERS, ActKind
from fleet_page.core.fleet import (
    DEADLINE_ALARMS,
    FAULTS,
    MISSION_STATES,
    ROBOT_STATES,
    RobotGroup,
)
from fleet_page.door.files import CHART
from route_protocol.devices import DeviceMode

SOURCES = {path.name: path.read_text() for path in PAGE_FOLDER.iterdir()
           if path.suffix in ('.js', '.html', '.css')}
TABLES = {name: json.loads((PAGE_FOLDER / f'{name}.json').read_text()) for name in ('en', 'de')}


def used_keys():
    found = set()
    for text in SOURCES.values():
        found |= set(re.findall(r'data-(?:t|label)="(\w+)"', text))
        found |= set(re.findall(r"\bt\('(\w+)'", text))
    found |= set(re.findall(r"\bone\('(\w+)'\)", SOURCES['missions.js']))
    found |= {f'act_{kind.value}' for kind in ActKind}
    found |= {f'answer_{word}' for word in ANSWERS}
    found |= {f'robot_{state}' for state in ROBOT_STATES}
    found |= {f'mission_{state}' for state in MISSION_STATES}
    found |= {f'deadline_{state}' for state in DEADLINE_ALARMS}
    found |= {f'resource_{kind.name}' for kind in ResourceKind}
    found |= {f'device_{mode.name}' for mode in DeviceMode}
    found |= {f'machine_{state.name}' for state in MachineState} | {'machine'}
    found |= {f'load_{state.name}' for state in LOAD_WORDS} | {'load_MOVES'}
    found |= {f'queue_{state.name}' for state in QueueState}
    tabs = re.search(r'TABS = \[(.*?)\]', SOURCES['main.js']).group(1)
    found |= {f'tab_{name}' for name in re.findall(r"'(\w+)'", tabs)}
    for name, list_ in (('layer', 'LAYERS'), ('key', 'KEY')):
        words = re.search(rf'{list_} = \[(.*?)\]', SOURCES['layers.js']).group(1)
        found |= {f'{name}_{word}' for word in re.findall(r"'(\w+)'", words)}
    columns = re.search(r'COLUMNS = \[(.*?)\]', SOURCES['missions.js']).group(1)
    found |= {f'column_{name}' for name in (*re.findall(r"'(\w+)'", columns), 'urgency')}
    found |= {f'count_{group.value}' for group in RobotGroup} | {'count_open', 'count_done'}
    return found | {f'todo_{name}' for name in FAULTS}


@pytest.mark.parametrize('language', TABLES)
def test_no_text_is_missing_and_none_is_empty(language):
    assert used_keys() - TABLES[language].keys() == set()
    assert all(TABLES[language].values())


def test_both_languages_have_the_same_texts_with_the_same_values():
    assert TABLES['en'].keys() == TABLES['de'].keys()
    for key, text in TABLES['en'].items():
        names = set(re.findall(r'\{(\w+)\}', text))
        assert set(re.findall(r'\{(\w+)\}', TABLES['de'][key])) == names, key


def test_no_text_is_left_over():
    text = ' '.join(SOURCES.values())
    used = used_keys()
    assert [key for key in TABLES['en'] if key not in used and f"'{key}'" not in text
            and not key.startswith(('todo_', 'mission_', 'robot_', 'words_', 'outage_'))] == []


def test_the_whole_page_is_sent_in_less_than_300_kb():
    chart = [Path(CHART)] if Path(CHART).is_file() else []
    sent = [len(gzip.compress(path.read_bytes())) for path in (*PAGE_FOLDER.iterdir(), *chart)]
    assert sum(sent) < 300_000


@pytest.mark.parametrize('name', SOURCES)
def test_texts_never_become_html_and_nothing_comes_from_elsewhere(name):
    text = SOURCES[name].replace('http://www.w3.org/2000/svg', '')
    for word in ('innerHTML', 'outerHTML', 'insertAdjacentHTML', 'document.write', 'eval(',
                 'http://', 'https://', '//cdn'):
        assert word not in text
    assert not re.search(r'<[^>]+ (style|on\w+)=', text) or name.endswith('.js')


def said_by_the_fleet_manager():
    """Returns all texts in the sources of the fleet manager and in the page's commands.

    {} stands for an inserted value.
    """
    packages = Path(__file__).parents[2]
    paths = [*packages.glob('fleet_core/src/*/supervision/*.py'),
             *packages.glob('fleet_core/src/*/work/*.py'),
             *packages.glob('graph_fleet_manager/src/*/nodes/fleet_services.py'),
             *packages.glob('fleet_page/src/*/nodes/fleet_commands.py'),
             *packages.glob('fleet_page/src/*/core/page.py'),
             *packages.glob('fleet_requests/src/*/*.py')]
    return '\n'.join(text for path in paths for text in texts_in(ast.parse(path.read_text())))


def texts_in(tree):
    """Yields all texts in Python code with {} for inserted values, and the parts between these
    values.
    """
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr):
            yield ''.join(part.value if isinstance(part, ast.Constant) else '{}'
                          for part in node.values)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


PUT_TOGETHER = ('words_busy', 'words_any_busy', 'words_all_charge', 'words_cancelled_by',
                'words_closed', 'words_closed_to_load', 'words_fleet_goes_on', 'words_too_near',
                'words_step_person', 'words_step_program', 'words_step_device', 'words_unload',
                'words_unload_unknown', 'words_laden', 'words_laden_unknown',
                'words_driver_restarted', 'words_device_restarted', 'words_robot_unsure',
                'words_device_unsure', 'words_robot_forgot', 'words_device_forgot')


def test_every_text_that_is_translated_is_still_said_by_the_fleet_manager():
    said = said_by_the_fleet_manager()
    missing = {key: text for key, text in TABLES['en'].items() if key.startswith('words_')
               and re.sub(r'\{\w+\}', '{}', text) not in said}
    assert missing.keys() <= set(PUT_TOGETHER), missing


@pytest.mark.parametrize('file, name', [
    ('why', ''), ('why', 'mission_reason'), ('why', 'robot_wait'), ('why', '_stay'),
    ('why', '_traffic'), ('why', '_turn'), ('waits', ''), ('work_desk', ''),
    ('work_desk', 'waits_for'),
    ('work_desk', '_words'), ('work_desk', '_show'), ('mission_book', 'waits_as'),
    ('mission_book', '_is_over')])
def test_every_reason_to_wait_or_to_end_is_translated(file, name):
    path = Path(__file__).parents[2] / f'fleet_core/src/fleet_core/supervision/{file}.py'
    known = '\n'.join(re.sub(r'\{\w+\}|loaded', '{}', text) for key, text in TABLES['en'].items()
                      if key.startswith('words_'))
    strange = {text for text in texts_in(said_by(ast.parse(path.read_text()), name))
               if ' ' in text.strip() and text.strip().replace('){}', ')') not in known
               and re.sub(r'\{\}$', '', text) not in known}
    assert strange == set()


def test_every_cause_for_which_a_step_asks_or_fails_is_translated():
    known = {re.sub(r'\{\w+\}', '{}', text) for key, text in TABLES['en'].items()
             if key.startswith('words_')}
    rules = Path(__file__).parents[2] / 'fleet_core/src/fleet_core/work/rules.py'
    calls = [call for call in ast.walk(ast.parse(rules.read_text())) if isinstance(call, ast.Call)
             and getattr(call.func, 'id', '') in ('_event', '_failed', '_unknown', '_lost')]
    causes = {text.replace('driver of {}', 'driver of the robot') for call in calls
              for argument in call.args for text in whole_texts_in(argument) if ' ' in text}
    assert len(causes) >= 3 and {one for one in causes if not one.startswith('{} ')} <= known


@pytest.mark.parametrize('path', ['core/page.py', 'nodes/fleet_commands.py'])
def test_every_outcome_of_an_act_is_translated(path):
    known = [re.sub(r'\{\w+\}', '{}', text) for key, text in TABLES['en'].items()
             if key.startswith('words_')]
    module = ast.parse((Path(__file__).parents[1] / 'src/fleet_page' / path).read_text())
    outcomes = [text for call in ast.walk(module)
                if isinstance(call, ast.Call) and getattr(call.func, 'id', '') == 'ActOutcome'
                for text in whole_texts_in(call) if ' ' in text]
    assert outcomes and set(outcomes) - set(known) == set()


def whole_texts_in(tree):
    """Yields the texts in Python code as whole texts, with {} for inserted values."""
    if isinstance(tree, ast.JoinedStr):
        yield next(texts_in(tree))
    elif isinstance(tree, ast.Constant) and isinstance(tree.value, str):
        yield tree.value
    else:
        for node in ast.iter_child_nodes(tree):
            yield from whole_texts_in(node)


def said_by(module, name):
    """Returns the code of the function `name`; if there is no name, the module's constants.

    The docstring of the function is left out.
    """
    if not name:
        return ast.Module([node for node in module.body if isinstance(node, ast.Assign)], [])
    function = next(node for node in ast.walk(module)
                    if isinstance(node, ast.FunctionDef) and node.name == name)
    function.body = function.body[1:] if ast.get_docstring(function) else function.body
    return function


@pytest.mark.parametrize('outage', Outage)
def test_every_outage_is_told_in_every_language(outage):
    assert TABLES['en'][f'outage_{outage.name}'] == outage.value
    assert TABLES['de'][f'outage_{outage.name}'] != outage.value


@pytest.mark.parametrize('state', RobotState)
def test_a_robots_state_has_the_same_words_everywhere(state):
    assert TABLES['en'][f'robot_{state.name}'] == state.words
    assert TABLES['en']['robot_working'] == WORKING
    assert TABLES['en']['robot_asks'] == ASKS


@pytest.mark.parametrize('prefix, words', [
    ('device_', {mode.name: text for mode, text in DEVICE_WORDS.items()}),
    ('machine_', {state.name: state.words for state in MachineState}),
    ('load_', {'MOVES': LOAD_MOVES, **{state.name: text for state, text in LOAD_WORDS.items()}}),
    ('queue_', {state.name: state.value for state in QueueState}),
    ('resource_', {kind.name: kind.value for kind in ResourceKind})])
def test_stations_devices_and_loads_have_the_same_words_on_the_page_and_in_rviz(prefix, words):
    assert {name: TABLES['en'][prefix + name] for name in words} == words
