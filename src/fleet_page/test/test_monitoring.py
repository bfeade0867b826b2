"""The alert rules for Prometheus and the dashboard for Grafana use only metrics of the page."""
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest
import yaml
from page_builders import page, show_fleet

CONFIG = Path(__file__).resolve().parents[1] / 'config'
ALERTS = CONFIG / 'prometheus_alerts.yml'
needs_promtool = pytest.mark.skipif(
    not shutil.which('promtool'), reason="promtool is missing: install Debian's package prometheus")
METRIC = re.compile(r'\bfleet_[a-z_]+\b')


def expressions():
    rules = [rule for group in yaml.safe_load(ALERTS.read_text())['groups']
             for rule in group['rules']]
    panels = json.loads((CONFIG / 'grafana_dashboard.json').read_text())['panels']
    return ([(rule['alert'], rule['expr']) for rule in rules]
            + [(panel['title'], target['expr']) for panel in panels for target in panel['targets']])


@pytest.fixture(scope='module')
def text(tmp_path_factory):
    shown = page(str(tmp_path_factory.mktemp('page')))
    show_fleet(shown)
    return shown.metrics(1)


@pytest.mark.parametrize('name, expression', expressions())
def test_each_metric_and_state_of_a_rule_or_panel_is_one_of_the_page(text, name, expression):
    known = set(re.findall(r'^# TYPE (\w+)', text, re.MULTILINE))
    unknown = {metric for metric in METRIC.findall(expression)
               if metric not in known and metric.replace('_bucket', '') not in known}
    assert not unknown, f'{name} uses {unknown}, which /metrics does not have'
    for metric, states in re.findall(r'(fleet_[a-z_]+)\{state=~?"([A-Z_|]+)"\}', expression):
        for state in states.split('|'):
            assert f'{metric}{{state="{state}"}}' in text, f'{name}: {metric} has no state {state}'


def test_each_rule_says_what_happened_and_what_to_do():
    for group in yaml.safe_load(ALERTS.read_text())['groups']:
        for rule in group['rules']:
            assert rule['labels']['severity'] in ('page', 'ticket'), rule['alert']
            assert set(rule['annotations']) == {'summary', 'description'}, rule['alert']


@needs_promtool
def test_promtool_finds_no_fault_in_the_metrics(text):
    done = subprocess.run(['promtool', 'check', 'metrics'], input=text.encode(), timeout=60,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == 0, done.stdout.decode()


@needs_promtool
@pytest.mark.parametrize('kind', ['check', 'test'])
def test_promtool_accepts_the_rules_and_each_trouble_raises_its_alert(kind, tmp_path):
    file = ALERTS
    if kind == 'test':
        file = tmp_path / 'test.yml'
        tests = Path(__file__).with_name('prometheus_alerts_test.yml').read_text()
        file.write_text(tests.replace('RULES', str(ALERTS)))
    done = subprocess.run(['promtool', kind, 'rules', str(file)], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, timeout=60)
    assert done.returncode == 0, done.stdout.decode()
