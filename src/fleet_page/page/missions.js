// Missions: a new mission by clicks, favourites, open and ended missions.
import { $, make, showRows } from './dom.js';
import { entries, all } from './server.js';
import { t, duration, said } from './texts.js';
import { knowsVertex, showChosen, vertexName } from './map.js';

const OPEN = ['PENDING', 'ACTIVE', 'PAUSED', 'CANCELLING', 'NEEDS_PERSON', 'BLOCKED', 'PLANNED'];
let chosen = []; // {vertex, stay}
let editing = null, form = null, act = null, me = { role: 'see' };

export function startMissions(given) {
  act = given;
  $('add').onclick = addTyped;
  $('destination').addEventListener('keydown', event => { if (event.key === 'Enter') { event.preventDefault(); addTyped(); } });
  $('clear').onclick = () => { chosen = []; showChoice(); };
  $('send').addEventListener('submit', async event => {
    event.preventDefault();
    if (chosen.length && await act({ act: 'send', ...draft() })) { chosen = []; showChoice(); }
  });
  $('keep').onclick = async () => {
    const name = $('favourite_name').value.trim();
    if (name && chosen.length && await act({ act: 'add_favourite', name, ...draft() })) $('favourite_name').value = '';
  };
}

export function chooseVertex(vertex) {
  chosen.push({ vertex, stay: 0 });
  showChoice();
}

function addTyped() {
  const vertex = parseInt($('destination').value, 10);
  if (!knowsVertex(vertex)) { act.say(t('no_vertex')); return; }
  $('destination').value = '';
  chooseVertex(vertex);
}

function draft() {
  const stays = chosen.map(one => one.stay);
  return {
    destinations: chosen.map(one => one.vertex), robot: $('send_robot').value, robot_type: $('send_type').value,
    priority: parseInt($('send_priority').value, 10) || 0, stays: stays.some(stay => stay !== 0) ? stays : [] };
}

function showChoice() {
  showChosen(chosen.map(one => one.vertex));
  $('chosen').replaceChildren(...chosen.map((one, k) => {
    const stay = make('input', { type: 'number', value: Math.max(0, one.stay), min: 0, max: 1000000, 'aria-label': t('stay') });
    const until = make('input', { type: 'checkbox' });
    until.checked = one.stay < 0;
    stay.disabled = until.checked;
    stay.onchange = () => { one.stay = Number(stay.value) || 0; };
    until.onchange = () => { stay.disabled = until.checked; one.stay = until.checked ? -1 : Number(stay.value) || 0; };
    return make('li', {}, vertexName(one.vertex), ' ', make('label', {}, t('stay'), ' ', stay, ' s '), make('label', {}, until, ' ', t('until_released')), ' ',
      make('button', { type: 'button', 'aria-label': t('remove_destination', { vertex: one.vertex }), onclick: () => { chosen.splice(k, 1); showChoice(); } }, '×'));
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

export function showPlaces(vertices) {
  $('places').replaceChildren(...vertices.filter(vertex => vertex[3] !== 'cut').map(vertex => make('option', { value: vertexName(vertex[0]) })));
}

export function showMissions(person, language) {
  me = person;
  const robots = all('robot:');
  options($('send_robot'), robots.map(([name]) => name).sort());
  options($('send_type'), [...new Set(robots.map(([, robot]) => robot.type))].sort());
  showFavourites(language);
  const missions = all('mission:').map(([key, mission]) => ({ key, ...mission }));
  const open = missions.filter(mission => OPEN.includes(mission.state)).sort((a, b) => (b.priority || 0) - (a.priority || 0) || a.stamp - b.stamp);
  const ended = missions.filter(mission => !OPEN.includes(mission.state)).reverse().slice(0, 100);
  const now = Date.now() / 1000;
  const isStopped = Boolean(entries.get('stop'));
  showRows($('open'), open.map(mission => ({ ...mission, stands: isStopped && mission.state === 'ACTIVE', left: mission.ends_at && !isStopped ? duration(mission.ends_at - now) : '', editing: editing === mission.id })), mission => mission.key, missionRow, language + me.role);
  showRows($('ended'), ended, mission => mission.key, missionRow, language);
}

function showFavourites(language) {
  const favourites = Object.entries(entries.get('favourites') || {}).map(([name, content]) => ({ name, ...content }));
  showRows($('favourites'), favourites, favourite => favourite.name, favourite => make('li', { class: 'row' },
    make('span', {}, `${favourite.name}: ${favourite.destinations.join(' → ')}`),
    make('button', { 'data-act': 'use', onclick: () => use(favourite) }, t('use')),
    make('button', { 'data-act': 'remove', 'aria-label': `${t('remove')} ${favourite.name}`, onclick: () => act({ act: 'remove_favourite', name: favourite.name }) }, t('remove'))), language);
}

function use(favourite) {
  chosen = favourite.destinations.map((vertex, k) => ({ vertex, stay: favourite.stays[k] || 0 }));
  $('send_robot').value = favourite.robot; $('send_type').value = favourite.robot_type; $('send_priority').value = favourite.priority;
  showChoice();
}

function missionRow(mission) {
  const isOpen = OPEN.includes(mission.state);
  const way = (mission.destinations || []).map((vertex, k) => k < mission.reached ? `✓${vertex}` : k === mission.reached && isOpen ? `▶${vertexName(vertex)}` : String(vertex)).join(' → ');
  const words = [mission.template || '', mission.robot || mission.wanted_robot || mission.robot_type || t('any'), way, mission.alarm ? t(`deadline_${mission.alarm}`) : '',
    mission.left ? t('to_go', { time: mission.left }) : '', mission.priority ? `${t('priority')} ${mission.priority}` : '', mission.by ? t('by', { person: mission.by }) : ''].filter(Boolean).join(' · ');
  const row = make('li', {}, make('span', { class: ['FAILED', 'REFUSED', 'NEEDS_PERSON', 'EXPIRED'].includes(mission.state) ? 'state bad' : 'state' }, t(mission.stands ? 'mission_STANDS' : `mission_${mission.state}`)), ` ${mission.id} · ${words}`,
    mission.reason ? make('p', { class: 'soft' }, said(mission.reason)) : '');
  if (isOpen && me.role !== 'see') {
    const button = (name, kind) => make('button', { 'data-act': kind, onclick: () => act({ act: kind, mission: mission.id }) }, t(name));
    row.append(make('p', { class: 'row' }, button('cancel', 'cancel'),
      mission.state === 'PAUSED' ? button('continue', 'continue') : button('pause', 'pause'), button('release', 'release'),
      make('button', { 'data-act': 'change', 'aria-expanded': String(mission.editing), onclick: () => { editing = mission.editing ? null : mission.id; form = null; showMissions(me, ''); } }, t('change'))));
    if (mission.editing) row.append(form = form || changeForm(mission)); // keeps the user's input when the mission changes
  }
  return row;
}

function changeForm(mission) {
  const priority = make('input', { type: 'number', value: mission.priority || 0 });
  const way = make('input', { value: (mission.destinations || []).slice(mission.reached).join(' ') });
  const form = make('form', { class: 'row' }, make('label', {}, t('priority'), ' ', priority), make('label', {}, t('remaining_destinations'), ' ', way), make('button', { class: 'main' }, t('apply')));
  form.addEventListener('submit', event => {
    event.preventDefault();
    const destinations = way.value.split(/[\s,]+/).filter(Boolean).map(Number);
    if (destinations.some(vertex => !knowsVertex(vertex))) { act.say(t('no_vertex')); return; }
    editing = null;
    const same = JSON.stringify(destinations) === JSON.stringify((mission.destinations || []).slice(mission.reached));
    act({ act: 'modify', mission: mission.id, priority: parseInt(priority.value, 10) || 0, destinations: same ? [] : destinations });
  });
  return form;
}
