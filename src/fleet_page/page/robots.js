// The list of robots. For the chosen robot it shows acts, battery, last missions and events; the map can follow the robot.
import { $, make, makeSvg, showRows, withCode } from './dom.js';
import { all, get } from './server.js';
import { clockOf, dateOf, language, momentOf, said, store, stored, t } from './texts.js';
import { chooseRobot, colourOf, followRobot, loadState, loadWords, outageWords, robotWords } from './map.js';

export const GROUPS = ['idle', 'driving', 'working', 'waiting', 'charging', 'trouble', 'away'];
const MOST_MISSIONS = 5, MOST_EVENTS = 8;
const FRESH = 60000; // ms after which the page asks for battery and events again
const GAP = 900; // s; if two values of the battery are further apart, the curve has a gap
const CURVE = { width: 300, height: 60 };
let me = { role: null }, act = null, chosen = '', followed = '';
let log = { robot: '', of: '', at: 0, number: 0, charges: [], events: [] }; // of the chosen robot

export function startRobots(given) {
  act = given;
  $('robot_group').onchange = () => showRobots(me);
  $('faults_box').open = stored('faults') === 'open';
  $('faults_box').addEventListener('toggle', () => store('faults', $('faults_box').open ? 'open' : 'folded'));
}

export function showGroup(group) {
  $('robot_group').value = group;
  showRobots(me);
}

export function showRobots(person) {
  me = person;
  showGroups();
  showFaults();
  askForLog();
  const group = $('robot_group').value;
  const robots = all('robot:').map(([name, robot]) => ({ name, ...robot })).filter(robot => !group || robot.group === group || robot.name === chosen)
    .sort((a, b) => a.name.localeCompare(b.name, undefined, { numeric: true }))
    .map(robot => robot.name === chosen ? { ...robot, isFollowed: robot.name === followed, missions: missionsOf(robot.name), missionName: robot.mission === null ? '' : nameOf(robot.mission), log: log.number } : robot);
  showRows($('robots'), robots, robot => robot.name, robotRow, language + me.role + chosen);
}

// Shows what keeps robots from working: the code (for the documentation), the words, the beginning and the remedy.
function showFaults() {
  const faults = all('robot:').map(([name, robot]) => ({ name, code: robot.fault, since: robot.fault_since, why: robot.fault === 'NOT_OPEN' ? t('not_open', { name: robot.not_open }) : outageWords(robot) || t(`outage_${robot.outage}`) })).filter(fault => fault.code)
    .sort((a, b) => a.since - b.since || a.name.localeCompare(b.name, undefined, { numeric: true }));
  showRows($('faults'), faults, fault => fault.name, ({ name, code, since, why }) => make('li', { class: 'fault' },
    make('button', { class: 'line', 'data-act': 'choose', onclick: () => { if (name !== chosen) choose(name); } }, colourDot(name), make('b', {}, name), make('span', { class: 'words' }, ...withCode(why)), make('code', {}, code)),
    make('p', { class: 'soft' }, t('since', { time: momentOf(since) }), ' · ', t(`todo_${code}`))), language);
  $('fault_count').textContent = `(${faults.length})`;
  $('no_faults').hidden = faults.length > 0;
}

function showGroups() {
  const select = $('robot_group');
  if (select.shown === language) return;
  select.shown = language;
  const before = select.value;
  select.replaceChildren(make('option', { value: '' }, t('all')), ...GROUPS.map(group => make('option', { value: group }, t(`count_${group}`))));
  select.value = before;
}

// Asks for battery and events of the chosen robot when the robot is chosen, when it changes, and after some time.
async function askForLog() {
  const robot = chosen && all(`robot:${chosen}`).find(([rest]) => !rest), of = robot && JSON.stringify([robot[1].state, robot[1].alarm, robot[1].works, robot[1].asks, robot[1].mission]);
  if (!robot || (log.robot === chosen && log.of === of && Date.now() - log.at < FRESH)) return;
  const number = log.number + 1;
  log = { ...log, ...log.robot === chosen ? {} : { charges: [], events: [] }, robot: chosen, of, at: Date.now(), number };
  const found = await get(`/api/robot?name=${encodeURIComponent(chosen)}`).catch(() => null);
  if (!found || log.number !== number) return;
  log = { ...log, ...found, number: number + 1 };
  showRobots(me);
}

const missionsOf = name => all('mission:').map(([, mission]) => mission).filter(mission => mission.robot === name).reverse().slice(0, MOST_MISSIONS)
  .map(({ id, serial, state, reason, ended, stamp }) => ({ id, serial, state, reason, at: ended || stamp }));

// Returns the short name of a mission for people; without a serial, the id of its request.
export const shortName = mission => mission.serial ? `M${mission.serial}` : String(mission.id);
export const fullName = mission => mission.serial ? `${shortName(mission)} (${mission.id})` : String(mission.id);

function nameOf(id) {
  const known = all('mission:').map(([, mission]) => mission).filter(mission => mission.id === id);
  return known.length ? shortName(known[known.length - 1]) : String(id);
}

export function colourDot(name) {
  const dot = make('span', { class: 'dot', 'aria-hidden': 'true' });
  dot.style.background = colourOf(name);
  return dot;
}

function robotRow(robot) {
  const isChosen = robot.name === chosen, charge = robot.battery === null ? null : Math.round(100 * robot.battery);
  const row = make('li', { class: [isChosen ? 'chosen' : '', robot.alarm || robot.asks ? 'trouble' : ''].filter(Boolean).join(' ') || null },
    make('button', { class: 'line', 'data-act': 'choose', 'aria-expanded': String(isChosen), onclick: () => choose(robot.name) },
      colourDot(robot.name), make('b', {}, robot.name), make('span', { class: 'words' }, ...withCode(robotWords(robot)), isChosen ? '' : loadOf(robot)),
      make('span', { class: charge !== null && charge <= 20 ? 'charge bad' : 'charge' }, charge === null ? '' : `${charge} %`)));
  if (isChosen) row.append(...details(robot));
  return row;
}

const loadOf = robot => loadWords(robot) && make('span', { class: loadState(robot) === 'UNKNOWN' ? 'bad' : null }, ` · ${loadWords(robot)}`);

function details(robot) {
  const button = kind => make('button', { 'data-act': kind, onclick: () => robotAct(kind, robot.name) }, t(`act_${kind}`));
  const acts = me.role === 'see' ? [] : [robot.state === 'OUT_OF_SERVICE' ? '' : button('out'), button('in'), me.role === 'admin' ? button('absent') : ''];
  return [make('p', { class: 'soft' }, [robot.type, robot.software ? t('software', robot) : '', robot.mission ? `${t('mission')} ${robot.missionName}` : ''].filter(Boolean).join(' · '), loadOf(robot)),
    robot.alarm ? make('p', { class: 'bad' }, `→ ${t(`todo_${robot.alarm}`)}`) : '',
    make('p', { class: 'row' }, make('button', { 'data-act': 'follow', 'aria-pressed': String(Boolean(robot.isFollowed)), onclick: () => followRobot(followed === robot.name ? '' : robot.name) }, t('follow')), ...acts),
    ...log.charges.length ? [make('h2', {}, t('battery_curve')), curveOf(log.charges, robot)] : [],
    robot.missions.length ? make('h2', {}, t('last_missions')) : '',
    lines(robot.missions, mission => [make('span', { title: String(mission.id) }, shortName(mission)), ` · ${t(`mission_${mission.state}`)}`, ...mission.reason ? withCode(` · ${said(mission.reason)}`) : []]),
    make('h2', {}, t('latest_events')),
    log.events.length ? lines(log.events.slice(0, MOST_EVENTS).map(event => ({ ...event, at: event.time, isBad: Boolean(event.alarm) })),
      event => [...withCode(robotWords(event)), event.mission === null ? '' : ` · ${t('mission')} ${nameOf(event.mission)}`]) : make('p', { class: 'soft' }, t('no_events'))];
}

const lines = (items, words) => make('ul', { class: 'lines' }, ...items.map(item => make('li', { class: item.isBad ? 'bad' : null },
  make('time', { title: dateOf(item.at) }, clockOf(item.at)), make('span', {}, ...words(item)))));

function curveOf(charges, robot) {
  const begin = charges[0][0], end = Math.max(Date.now() / 1000, begin + 3600);
  const place = ([time, charge]) => `${((time - begin) / (end - begin) * CURVE.width).toFixed(1)} ${((1 - charge) * CURVE.height).toFixed(1)}`;
  const known = [...charges, ...robot.battery === null ? [] : [[Date.now() / 1000, robot.battery]]], least = Math.round(100 * Math.min(...known.map(([, charge]) => charge)));
  const way = known.map((one, k) => `${k && one[0] - known[k - 1][0] < GAP ? 'L' : 'M'}${place(one)}`).join('');
  const now = robot.battery === null ? '-' : Math.round(100 * robot.battery);
  const curve = makeSvg('svg', { class: 'curve', viewBox: `0 0 ${CURVE.width} ${CURVE.height}`, preserveAspectRatio: 'none', role: 'img', 'aria-label': t('battery_words', { now, least }) });
  curve.append(...[0.2, 0.5, 1].map(level => makeSvg('path', { class: 'grid', d: `M0 ${(1 - level) * CURVE.height}H${CURVE.width}` })), makeSvg('path', { class: 'line', d: way }));
  return make('figure', {}, curve, make('figcaption', {}, make('time', { title: dateOf(begin) }, clockOf(begin)), make('span', {}, t('battery_words', { now, least })), make('span', {}, t('now'))));
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
