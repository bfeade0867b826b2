// Missions: a new mission by clicks, favourites, and the tables of open and ended missions.
import { $, make, openMenu, showRows, withCode } from './dom.js';
import { entries, all } from './server.js';
import { t, clockOf, dateOf, duration, language, said, store, stored } from './texts.js';
import { knowsVertex, showChosen, vertexName } from './map.js';
import { stationPlaces } from './resources.js';
import { colourDot, fullName, shortName } from './robots.js';
import { chosenTemplate, clearParameters, fillParameter, runOf, showTemplates, startTemplates } from './templates.js';

const OPEN = ['PENDING', 'ACTIVE', 'PAUSED', 'CANCELLING', 'NEEDS_PERSON', 'BLOCKED', 'PLANNED'];
const ENDED = ['SUCCEEDED', 'FAILED', 'REFUSED', 'CANCELLED', 'EXPIRED'];
const URGENT = ['NEEDS_PERSON']; // states that come first
const BAD = ['FAILED', 'REFUSED', 'NEEDS_PERSON', 'EXPIRED'];
const MOST_ENDED = 100;
// For each column, the value by which it orders a list. At first a list is in the order `urgency`.
const ORDERS = {
  urgency: null, state: mission => t(`mission_${mission.state}`), id: mission => mission.serial || mission.id, robot: mission => mission.robot || '',
  asked: mission => mission.stamp, to_end: mission => mission.ended || mission.ends_at || Infinity, by: mission => mission.by || '', priority: mission => -(mission.priority || 0) };
const COLUMNS = ['state', 'id', 'robot', 'way', 'to_end', 'asked', 'by', 'priority'];
let chosen = []; // {place, stay}; place: id of a vertex, or name of a station or group
let editing = null, form = null, act = null, me = { role: 'see' }, order = 'urgency', isBackwards = false;

export function startMissions(given) {
  act = given;
  $('add').onclick = addTyped;
  $('destination').addEventListener('keydown', event => { if (event.key === 'Enter') { event.preventDefault(); addTyped(); } });
  startTemplates(given);
  $('clear').onclick = () => { chosen = []; clearParameters(); showChoice(); };
  $('send').addEventListener('submit', async event => {
    event.preventDefault();
    const template = chosenTemplate();
    if (template) {
      if (await act({ ...runOf(template), ...wishes() })) clearParameters();
    } else if (chosen.length && await act({ act: 'send', ...draft() })) { chosen = []; showChoice(); }
  });
  $('keep').onclick = async () => {
    const name = $('favourite_name').value.trim();
    if (name && chosen.length && await act({ act: 'add_favourite', name, ...draft() })) $('favourite_name').value = '';
  };
  $('new_mission').open = stored('new_mission') !== 'folded';
  $('new_mission').addEventListener('toggle', () => store('new_mission', $('new_mission').open ? 'open' : 'folded'));
  $('mission_search').oninput = $('mission_state').onchange = () => showTables();
  $('mission_sort').onchange = () => sortBy($('mission_sort').value, false);
}

function sortBy(name, backwards) {
  order = name; isBackwards = backwards;
  $('mission_sort').value = name;
  showTables();
}

export function choosePlace(place) {
  $('new_mission').open = true;
  if (chosenTemplate()) { fillParameter(place); return; }
  chosen.push({ place, stay: 0 });
  showChoice();
}

function addTyped() {
  const typed = $('destination').value.trim(), vertex = /^\d+( |$)/.test(typed) ? parseInt(typed, 10) : 0;
  const place = stationPlaces(typed).length ? typed : vertex;
  if (!place || (place === vertex && !knowsVertex(vertex))) { act.say(t('no_vertex')); return; }
  $('destination').value = '';
  choosePlace(place);
}

const placeName = place => typeof place === 'number' ? vertexName(place) : place;

function draft() {
  const stays = chosen.map(one => one.stay);
  return {
    destinations: chosen.map(one => one.place), ...wishes(), stays: stays.some(stay => stay !== 0) ? stays : [] };
}

const wishes = () => ({ robot: $('send_robot').value, robot_type: $('send_type').value, priority: parseInt($('send_priority').value, 10) || 0 });

function showChoice() {
  showChosen(chosen.map(({ place }) => typeof place === 'number' ? [place] : stationPlaces(place)));
  $('chosen').replaceChildren(...chosen.map((one, k) => {
    const stay = make('input', { type: 'number', value: Math.max(0, one.stay), min: 0, max: 1000000, 'aria-label': t('stay') });
    const until = make('input', { type: 'checkbox' });
    until.checked = one.stay < 0;
    stay.disabled = until.checked;
    stay.onchange = () => { one.stay = Number(stay.value) || 0; };
    until.onchange = () => { stay.disabled = until.checked; one.stay = until.checked ? -1 : Number(stay.value) || 0; };
    return make('li', {}, placeName(one.place), ' ', make('label', {}, t('stay'), ' ', stay, ' s '), make('label', {}, until, ' ', t('until_released')), ' ',
      make('button', { type: 'button', 'aria-label': t('remove_destination', { vertex: placeName(one.place) }), onclick: () => { chosen.splice(k, 1); showChoice(); } }, '×'));
  }));
}

function options(select, values) {
  const text = JSON.stringify([values, t('any')]);
  if (select.shown === text) return;
  select.shown = text;
  const before = select.value;
  select.replaceChildren(make('option', { value: '' }, t('any')), ...values.map(value => make('option', { value }, value)));
  if (values.includes(before)) select.value = before;
}

let shownPlaces = [null, ''];
export function showPlaces(vertices) {
  const stations = all('resource:').filter(([name]) => stationPlaces(name).length).map(([name]) => name), names = stations.join('\n');
  if (shownPlaces[0] === vertices && shownPlaces[1] === names) return;
  shownPlaces = [vertices, names];
  $('places').replaceChildren(...[...stations, ...vertices.filter(vertex => vertex[3] !== 'cut').map(vertex => vertexName(vertex[0]))].map(value => make('option', { value })));
}

export function showMissions(person) {
  me = person;
  const robots = all('robot:');
  options($('send_robot'), robots.map(([name]) => name).sort((a, b) => a.localeCompare(b, undefined, { numeric: true })));
  options($('send_type'), [...new Set(robots.map(([, robot]) => robot.type))].sort());
  showFavourites();
  showTemplates(me);
  showTables();
}

function showTables() {
  showHeads();
  const now = Date.now() / 1000, isStopped = Boolean(entries.get('stop'));
  const missions = all('mission:').map(([key, mission]) => ({ key, ...mission }));
  const open = missions.filter(mission => OPEN.includes(mission.state)).sort((a, b) => URGENT.includes(b.state) - URGENT.includes(a.state) || (b.priority || 0) - (a.priority || 0) || a.stamp - b.stamp);
  const ended = missions.filter(mission => !OPEN.includes(mission.state)).reverse();
  const shownOpen = sorted(open.filter(isWanted)), shownEnded = sorted(ended.filter(isWanted)).slice(0, MOST_ENDED);
  showRows($('open'), shownOpen.map(mission => ({ ...mission, stands: isStopped && mission.state === 'ACTIVE', left: mission.ends_at && !isStopped ? duration(mission.ends_at - now) : '', editing: editing === mission.id })), mission => mission.key, missionRow, language + me.role);
  showRows($('ended'), shownEnded, mission => mission.key, missionRow, language);
  $('open_count').textContent = countWords(shownOpen.length, open.length);
  $('ended_count').textContent = countWords(shownEnded.length, ended.length);
}

const countWords = (shown, whole) => shown === whole ? `(${whole})` : t('shown_of', { shown, whole });

function isWanted(mission) {
  const state = $('mission_state').value, words = $('mission_search').value.trim().toLowerCase();
  if (state && mission.state !== state) return false;
  const text = [fullName(mission), mission.robot, mission.by, t(`mission_${mission.state}`), said(mission.reason || ''), ...(mission.destinations || []).map(vertexName)].join(' ').toLowerCase();
  return words.split(/\s+/).every(word => text.includes(word));
}

function sorted(missions) {
  const value = ORDERS[order], sign = isBackwards ? -1 : 1;
  if (!value) return missions;
  const compare = (a, b) => typeof a === 'string' ? a.localeCompare(b, language, { numeric: true }) : a < b ? -1 : a > b ? 1 : 0;
  return [...missions].sort((a, b) => sign * compare(value(a), value(b)));
}

function showHeads() {
  const shown = JSON.stringify([language, order, isBackwards]);
  for (const head of document.querySelectorAll('.missions thead')) {
    if (head.shown === shown) continue;
    head.shown = shown;
    const active = head.contains(document.activeElement) ? document.activeElement.dataset.order : null;
    head.replaceChildren(make('tr', {}, ...COLUMNS.map(name => make('th', { scope: 'col', class: name, 'aria-sort': order !== name ? null : isBackwards ? 'descending' : 'ascending' },
      ORDERS[name] ? make('button', { 'data-order': name, onclick: () => sortBy(name, order === name && !isBackwards) }, t(`column_${name}`)) : t(`column_${name}`))), make('td', {})));
    if (active) head.querySelector(`[data-order=${active}]`).focus();
  }
  const selects = language + order;
  if ($('mission_sort').shown === selects) return;
  $('mission_sort').shown = selects;
  $('mission_sort').replaceChildren(...Object.keys(ORDERS).map(name => make('option', { value: name }, t(`column_${name}`))));
  $('mission_sort').value = order;
  const state = $('mission_state').value;
  $('mission_state').replaceChildren(make('option', { value: '' }, t('all')), ...[...OPEN, ...ENDED].map(name => make('option', { value: name }, t(`mission_${name}`))));
  $('mission_state').value = state;
}

function showFavourites() {
  const favourites = Object.entries(entries.get('favourites') || {}).map(([name, content]) => ({ name, ...content }));
  showRows($('favourites'), favourites, favourite => favourite.name, favourite => make('li', { class: 'row' },
    make('span', {}, `${favourite.name}: ${favourite.destinations.join(' → ')}`),
    make('button', { 'data-act': 'use', onclick: () => use(favourite) }, t('use')),
    make('button', { 'data-act': 'remove', 'aria-label': `${t('remove')} ${favourite.name}`, onclick: () => act({ act: 'remove_favourite', name: favourite.name }) }, t('remove'))), language);
}

function use(favourite) {
  $('send_template').value = '';
  $('send_template').onchange();
  chosen = favourite.destinations.map((place, k) => ({ place, stay: favourite.stays[k] || 0 }));
  $('send_robot').value = favourite.robot; $('send_type').value = favourite.robot_type; $('send_priority').value = favourite.priority;
  showChoice();
}

function missionRow(mission) {
  const isOpen = OPEN.includes(mission.state), stops = (mission.destinations || []).length;
  const way = (mission.destinations || []).map((vertex, k) => k < mission.reached ? `✓${vertex}` : k === mission.reached && isOpen ? `▶${vertexName(vertex)}` : String(vertex)).join(' → ');
  const robot = mission.robot || mission.wanted_robot || mission.robot_type || t('any');
  const progress = isOpen && stops > 1 ? make('progress', { value: mission.reached, max: stops, 'aria-label': t('progress', { reached: mission.reached, stops }) }) : '';
  const row = make('tr', { class: BAD.includes(mission.state) && isOpen ? 'urgent' : null },
    make('td', { class: 'state' }, make('span', { class: BAD.includes(mission.state) ? 'bad' : null }, t(mission.stands ? 'mission_STANDS' : `mission_${mission.state}`)), ' '),
    make('td', { class: 'id' }, make('span', {}, shortName(mission)), mission.serial ? make('small', {}, String(mission.id)) : ''),
    make('td', { class: 'robot_name' }, mission.robot ? colourDot(mission.robot) : '', robot),
    make('td', { class: 'way' }, mission.template ? `${mission.template} · ` : '', way, progress, mission.alarm ? make('span', { class: 'bad' }, ` ${t(`deadline_${mission.alarm}`)}`) : '', mission.reason ? make('p', { class: 'soft' }, ...withCode(reasonWords(mission, me))) : '', answerButtons(mission, me)),
    make('td', { class: 'to_end' }, mission.left ? t('to_go', { time: mission.left }) : '', ...mission.ended ? at('ended', mission.ended) : []),
    make('td', { class: 'asked' }, ...at('asked', mission.stamp)),
    make('td', { class: 'by' }, ...mission.by ? [word('by'), mission.by] : []),
    make('td', { class: 'priority' }, ...mission.priority ? [word('priority'), String(mission.priority)] : []));
  const menu = make('td', { class: 'acts' });
  if (isOpen && me.role !== 'see') {
    const button = make('button', { 'data-act': 'menu', 'aria-haspopup': 'menu', 'aria-label': t('acts_of', { mission: shortName(mission) }) }, '⋯');
    button.addEventListener('click', () => openMenu(button, actsOf(mission)));
    menu.append(button);
  }
  row.append(menu);
  if (mission.editing) row.append(make('td', { class: 'edit' }, form = form || changeForm(mission))); // keeps the user's input when the mission changes
  return row;
}

// In a narrow panel each value has a word before it; in a wide panel it has a column.
const word = key => make('span', { class: 'word' }, `${t(key)} `);
const at = (key, seconds) => [word(key), make('time', { title: dateOf(seconds) }, clockOf(seconds))];

function actsOf(mission) {
  const one = kind => [kind, t(kind), () => act({ act: kind, mission: mission.id })];
  return [one(mission.state === 'PAUSED' ? 'continue' : 'pause'), one('release'), ['change', t('change'), () => edit(mission.editing ? null : mission.id)], one('cancel')];
}

function edit(id) {
  editing = id; form = null;
  showTables();
  if (form) form.querySelector('input').focus();
}

const canAnswer = (mission, person) => Boolean(mission.asks) && person.role !== 'see';

// Returns the reason of a mission's state. If the person has buttons to answer, the text does not name the command
// for the same act.
export const reasonWords = (mission, person) => said(mission.reason || '', canAnswer(mission, person));

// Returns buttons for the possible answers to a step. A step that only waits until a person has done it has no retry.
export function answerButtons(mission, person) {
  if (!canAnswer(mission, person)) return '';
  const answers = mission.state === 'NEEDS_PERSON' ? ['retry', 'skip', 'fail', 'done'] : ['skip', 'fail', 'done'];
  return make('p', { class: 'row', role: 'group', 'aria-label': t('answer_to', { mission: shortName(mission) }) }, ...answers.map(answer => make('button',
    { 'data-act': `answer_${answer}`, onclick: () => act({ act: 'answer', mission: mission.id, answer, step: mission.asks }) }, t(`answer_${answer}`))));
}

function changeForm(mission) {
  const priority = make('input', { type: 'number', value: mission.priority || 0 });
  const way = make('input', { value: (mission.destinations || []).slice(mission.reached).join(' ') });
  const form = make('form', { class: 'row' }, make('label', {}, t('priority'), ' ', priority), make('label', {}, t('remaining_destinations'), ' ', way), make('button', { class: 'main' }, t('apply')), make('button', { type: 'button', 'data-act': 'close_form', onclick: () => edit(null) }, t('do_not_change')));
  form.addEventListener('submit', event => {
    event.preventDefault();
    const destinations = way.value.split(/[\s,]+/).filter(Boolean).map(Number);
    if (destinations.some(vertex => !knowsVertex(vertex))) { act.say(t('no_vertex')); return; }
    edit(null);
    const same = JSON.stringify(destinations) === JSON.stringify((mission.destinations || []).slice(mission.reached));
    act({ act: 'modify', mission: mission.id, priority: parseInt(priority.value, 10) || 0, destinations: same ? [] : destinations });
  });
  return form;
}
