"""docs/upgrading.md names each message of 1.0.0 that has changed since, and each changed field.

test/vectors/release_1_0_0/messages.json has the lines of all messages, services and actions of
1.0.0, without comments.
"""
from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Dict, List, Set

ROOT = Path(__file__).resolve().parents[3]
BEFORE: Dict[str, List[str]] = json.loads(
    (ROOT / 'test/vectors/release_1_0_0/messages.json').read_text(encoding='utf-8'))
PAGE = (ROOT / 'docs/upgrading.md').read_text(encoding='utf-8')


def definition(file: Path) -> List[str]:
    """Returns the lines of a message, service or action without comments and needless blanks."""
    lines = (' '.join(line.partition('#')[0].split())
             for line in file.read_text(encoding='utf-8').splitlines())
    return [line.replace(' =', '=').replace('= ', '=') for line in lines if line]


NOW: Dict[str, List[str]] = {
    f'{file.parts[-3]}/{file.stem}': definition(file)
    for kind in ('msg', 'srv', 'action') for file in sorted(ROOT.glob(f'src/*_msgs/{kind}/*'))}


def names(lines: Set[str], constants: bool) -> Set[str]:
    """Returns the names of the constants in these lines if `constants`, else those of the fields.
    """
    return {re.split('[ =]', line)[1] for line in lines
            if line != '---' and ('=' in line) is constants}


def rows(page: str) -> Dict[str, str]:
    """Returns the text of the table rows about each message, by its name without the package."""
    section = page.partition('\n### Messages\n')[2].partition('\n### ')[0]
    told: Dict[str, str] = {}
    for line in section.splitlines():
        if line.startswith('|'):
            for name in re.findall(r'`(?:\w+/)?(\w+)`', line):
                told[name] = told.get(name, '') + line
    return told


def untold(page: str) -> List[str]:
    """Returns the changes of messages that are not in the table of the page."""
    told = rows(page)
    found: List[str] = []
    for message in sorted({*BEFORE, *NOW}):
        before, now = set(BEFORE.get(message, ())), set(NOW.get(message, ()))
        row = told.get(message.partition('/')[2], '')
        if message not in BEFORE:
            if not row and not is_part(message):
                found.append(f'{message} is new')
            continue
        changed = names(before ^ now, constants=False) | names(before - now, constants=True)
        found += [f'{message}: {name}' for name in sorted(changed) if f'`{name}`' not in row]
    return found


def is_part(message: str) -> bool:
    """Returns whether a message is only a part of other messages, which the table names instead."""
    kind = message.partition('/')[2]
    return any(re.match(rf'(\w+/)?{kind}(\[\])? ', line) for lines in NOW.values()
               for line in lines)


def test_each_changed_message_since_1_0_0_stands_on_the_page():
    assert len(BEFORE) == 40
    assert untold(PAGE) == []


def test_a_field_that_the_page_does_not_tell_is_found():
    without = PAGE.replace('`epoch_cause`', 'why an epoch began').replace('`SUCCEEDED`', 'success')
    assert untold(without) == ['itrci_nav_msgs/ExecutionRouteStates: epoch_cause',
                               'omron_ld90_msgs/ExecuteCommand: SUCCEEDED']
    assert 'itrci_nav_msgs/Timetables is new' in untold(PAGE.replace('`Timetables`', ''))
