"""Each text of the page is in both language tables, and the page loads nothing from elsewhere."""
import ast
import json
import re
from pathlib import Path

import pytest
from page_builders import PAGE_FOLDER

from fleet_core.supervision.fleet_view import RobotState
from fleet_core.supervision.outages import Outage
from fleet_page.core.acts import ActKind
from fleet_page.core.fleet import ALARMS, MISSION_STATES, ROBOT_STATES

SOURCES = {path.name: path.read_text() for path in PAGE_FOLDER.iterdir()
           if path.suffix in ('.js', '.html', '.css')}
TABLES = {name: json.loads((PAGE_FOLDER / f'{name}.json').read_text()) for name in ('en', 'de')}


def used_keys():
    found = set()
    for text in SOURCES.values():
        found |= set(re.findall(r'data-(?:t|label)="(\w+)"', text))
        found |= set(re.findall(r"\bt\('(\w+)'", text))
    found |= set(re.findall(r"button\('(\w+)', '\w+'\)", SOURCES['missions.js']))
    found |= {f'act_{kind.value}' for kind in ActKind}
    found |= {f'robot_{state}' for state in ROBOT_STATES}
    found |= {f'mission_{state}' for state in MISSION_STATES}
    found |= {f'deadline_{state}' for state in ALARMS}
    tabs = re.search(r'TABS = \[(.*?)\]', SOURCES['main.js']).group(1)
    found |= {f'tab_{name}' for name in re.findall(r"'(\w+)'", tabs)}
    needs = re.search(r'NEEDS_PERSON = \[(.*?)\]', SOURCES['main.js']).group(1)
    return found | {f'todo_{name}' for name in re.findall(r"'(\w+)'", needs)}


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


@pytest.mark.parametrize('name', SOURCES)
def test_texts_never_become_html_and_nothing_comes_from_elsewhere(name):
    text = SOURCES[name].replace('http://www.w3.org/2000/svg', '')
    for word in ('innerHTML', 'outerHTML', 'insertAdjacentHTML', 'document.write', 'eval(',
                 'http://', 'https://', '//cdn'):
        assert word not in text
    assert not re.search(r'<[^>]+ (style|on\w+)=', text) or name.endswith('.js')


def said_by_the_fleet_manager():
    """All texts in its sources and in the page's commands, with {} for inserted values."""
    packages = Path(__file__).parents[2]
    paths = [*packages.glob('fleet_core/src/*/supervision/*.py'),
             *packages.glob('graph_fleet_manager/src/*/nodes/fleet_services.py'),
             *packages.glob('fleet_page/src/*/nodes/fleet_commands.py'),
             *packages.glob('fleet_requests/src/*/*.py')]
    texts = []
    for path in paths:
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.JoinedStr):
                texts.append(''.join(part.value if isinstance(part, ast.Constant) else '{}'
                                     for part in node.values))
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value)
    return '\n'.join(texts)


PUT_TOGETHER = ('words_busy', 'words_any_busy', 'words_all_charge', 'words_cancelled_by',
                'words_closed', 'words_fleet_goes_on', 'words_too_near')


def test_every_text_that_is_translated_is_still_said_by_the_fleet_manager():
    said = said_by_the_fleet_manager()
    missing = {key: text for key, text in TABLES['en'].items() if key.startswith('words_')
               and re.sub(r'\{\w+\}', '{}', text) not in said}
    assert missing.keys() <= set(PUT_TOGETHER), missing


@pytest.mark.parametrize('outage', Outage)
def test_every_outage_is_told_in_every_language(outage):
    assert TABLES['en'][f'outage_{outage.name}'] == outage.value
    assert TABLES['de'][f'outage_{outage.name}'] != outage.value


@pytest.mark.parametrize('state', RobotState)
def test_a_robots_state_has_the_same_words_everywhere(state):
    assert TABLES['en'][f'robot_{state.name}'] == state.words
