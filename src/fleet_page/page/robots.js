// The list of robots. The chosen one shows its acts and its last missions, and the map can follow it.
import { $, make, showRows, withCode } from './dom.js';
import { all } from './server.js';
import { language, said, t } from './texts.js';
import { chooseRobot, followRobot, hueOf, robotWords } from './map.js';

export const GROUPS = ['idle', 'driving', 'standing', 'charging', 'trouble', 'away'];
const MOST_MISSIONS = 5;
let me = { role: null }, act = null, chosen = '', followed = '';

export function startRobots(given) {
  act = given;
  $('robot_group').onchange = () => showRobots(me);
}

export function showGroup(group) {
  $('robot_group').value = group;
  showRobots(me);
}

export function showRobots(person) {
  me = person;
  showGroups();
  const group = $('robot_group').value;
  const robots = all('robot:').map(([name, robot]) => ({ name, ...robot })).filter(robot => !group || robot.group === group || robot.name === chosen)
    .sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }))
    .map(robot => robot.name === chosen ? { ...robot, isFollowed: robot.name === followed, missions: missionsOf(robot.name) } : robot);
  showRows($('robots'), robots, robot => robot.name, robotRow, language + me.role + chosen);
}

function showGroups() {
  const select = $('robot_group');
  if (select.shown === language) return;
  select.shown = language;
  const before = select.value;
  select.replaceChildren(make('option', { value: '' }, t('all')), ...GROUPS.map(group => make('option', { value: group }, t(`count_${group}`))));
  select.value = before;
}

const missionsOf = name => all('mission:').map(([, mission]) => mission).filter(mission => mission.robot === name).reverse().slice(0, MOST_MISSIONS)
  .map(({ id, state, reason }) => ({ id, state, reason }));

export function colourDot(name) {
  const dot = make('span', { class: 'dot', 'aria-hidden': 'true' });
  dot.style.background = `hsl(${hueOf(name)} 60% 42%)`;
  return dot;
}

function robotRow(robot) {
  const isChosen = robot.name === chosen, charge = robot.battery === null ? null : Math.round(100 * robot.battery);
  const row = make('li', { class: [isChosen ? 'chosen' : '', robot.alarm ? 'trouble' : ''].filter(Boolean).join(' ') || null },
    make('button', { class: 'line', 'data-act': 'choose', 'aria-expanded': String(isChosen), onclick: () => choose(robot.name) },
      colourDot(robot.name), make('b', {}, robot.name), make('span', { class: 'words' }, ...withCode(robotWords(robot))),
      make('span', { class: charge !== null && charge <= 20 ? 'charge bad' : 'charge' }, charge === null ? '' : `${charge} %`)));
  if (isChosen) row.append(...details(robot));
  return row;
}

function details(robot) {
  const button = kind => make('button', { 'data-act': kind, onclick: () => robotAct(kind, robot.name) }, t(`act_${kind}`));
  const acts = me.role === 'see' ? [] : [robot.state === 'OUT_OF_SERVICE' ? '' : button('out'), button('in'), me.role === 'admin' ? button('absent') : ''];
  return [make('p', { class: 'soft' }, [robot.type, robot.mission ? `${t('mission')} ${robot.mission}` : ''].filter(Boolean).join(' · ')),
    robot.alarm ? make('p', { class: 'bad' }, `→ ${t(`todo_${robot.alarm}`)}`) : '',
    make('p', { class: 'row' }, make('button', { 'data-act': 'follow', 'aria-pressed': String(Boolean(robot.isFollowed)), onclick: () => followRobot(followed === robot.name ? '' : robot.name) }, t('follow')), ...acts),
    robot.missions.length ? make('h3', {}, t('last_missions')) : '',
    make('ul', {}, ...robot.missions.map(mission => make('li', {}, `${mission.id} · ${t(`mission_${mission.state}`)}`, ...mission.reason ? withCode(` · ${said(mission.reason)}`) : [])))];
}

function robotAct(kind, robot) {
  if (kind === 'absent' && !confirm(t('sure_absent', { robot }))) return;
  act({ act: kind, robot });
}

export function choose(name) {
  chosen = chosen === name ? '' : name;
  if (followed && followed !== chosen) followRobot('');
  chooseRobot(chosen);
  if ([...$('send_robot').options].some(option => option.value === chosen)) $('send_robot').value = chosen;
  showRobots(me);
  [...$('robots').children].find(row => row.dataset.key === chosen)?.scrollIntoView({ block: 'nearest' });
}

export function noteFollowed(name) {
  followed = name;
  showRobots(me);
}
