// Timetables, and missions of templates. A person fills in a template's parameters by name or by clicks on the map.
import { $, make, showRows } from './dom.js';
import { entries } from './server.js';
import { language, store, stored, t } from './texts.js';
import { vertexName } from './map.js';

let act = null, filling = ''; // the parameter that a click on the map fills in

export function startTemplates(given) {
  act = given;
  $('send_template').onchange = showParameters;
  $('timetables_box').open = stored('timetables') === 'open';
  $('timetables_box').addEventListener('toggle', () => store('timetables', $('timetables_box').open ? 'open' : 'folded'));
}

const known = () => entries.get('templates') || [];
export const chosenTemplate = () => known().find(template => template.name === $('send_template').value) || null;
const inputs = () => [...$('parameters').querySelectorAll('input')];

export function showTemplates(me) {
  const select = $('send_template'), shown = JSON.stringify([known(), t('no_template')]);
  if (select.shown !== shown) {
    select.shown = shown;
    const before = select.value;
    select.replaceChildren(make('option', { value: '' }, t('no_template')), ...known().map(({ name }) => make('option', { value: name }, name)));
    select.value = known().some(({ name }) => name === before) ? before : '';
    $('template_choice').hidden = !known().length;
    showParameters();
  }
  showTimetables(me);
}

function showParameters() {
  const template = chosenTemplate(), shown = JSON.stringify([template, language]);
  $('by_clicks').hidden = $('keep_fields').hidden = Boolean(template);
  $('parameters').hidden = !template;
  if ($('parameters').shown === shown) return;
  $('parameters').shown = shown;
  const before = new Map(inputs().map(input => [input.name, input.value]));
  $('parameters').replaceChildren(...(template ? template.parameters : []).map(name => {
    const input = make('input', { name, list: 'places', autocomplete: 'off', required: true, maxlength: 100 });
    input.value = before.get(name) || '';
    input.addEventListener('focus', () => mark(name));
    return make('label', {}, make('span', {}, name), ' ', input);
  }));
  mark(template ? template.parameters[0] || '' : '');
}

function mark(name) {
  filling = name;
  for (const input of inputs()) input.classList.toggle('filling', input.name === name);
}

// A click on the map fills the field that the person entered last. The next click fills the next empty field.
export function fillParameter(place) { // id of a vertex, or name of a station
  const input = inputs().find(one => one.name === filling);
  if (!input) return;
  input.value = typeof place === 'number' ? vertexName(place) : place;
  const next = inputs().find(one => !one.value.trim());
  mark(next ? next.name : filling);
}

const wordOf = text => /^\d+ /.test(text) && vertexName(parseInt(text, 10)) === text ? String(parseInt(text, 10)) : text;

export const runOf = template => ({ act: 'run', name: template.name, arguments: Object.fromEntries(inputs().map(input => [input.name, wordOf(input.value.trim())])) });

export function clearParameters() {
  for (const input of inputs()) input.value = '';
  mark(inputs().length ? inputs()[0].name : '');
}

// -- timetables --------------------------------------------------------------------------------

const DAYS = 7, DAY = 1440;
const clock = minute => `${String(Math.floor(minute % DAY / 60)).padStart(2, '0')}:${String(minute % 60).padStart(2, '0')}`;
const dayName = day => new Date(Date.UTC(2024, 0, 1 + day)).toLocaleDateString(language, { weekday: 'short', timeZone: 'UTC' }); // a Monday
const nextWords = seconds => new Date(seconds * 1000).toLocaleString(language, { weekday: 'short', hour: '2-digit', minute: '2-digit' });

function runsWords({ every, begin, end, days }) {
  const period = every % 60 ? `${every} min` : `${every / 60} h`;
  const isConnected = days.length > 2 && days[days.length - 1] - days[0] === days.length - 1;
  const shown = isConnected ? `${dayName(days[0])}–${dayName(days[days.length - 1])}` : days.map(dayName).join(', ');
  return [t('every', { period }), begin === 0 && end === DAY - 1 ? '' : `${clock(begin)}–${clock(end)}`, days.length === DAYS ? '' : shown].filter(Boolean).join(', ');
}

function showTimetables(me) {
  const timetables = entries.get('timetables') || [];
  $('timetables_box').hidden = !timetables.length;
  $('timetable_count').textContent = `(${timetables.length})`;
  showRows($('timetables'), timetables, one => one.name, one => make('li', { class: 'timetable' },
    make('p', { class: 'row' }, make('b', {}, one.name), make('span', { class: one.next === null ? 'bad' : null }, one.next === null ? t('is_paused') : t('next_run', { time: nextWords(one.next) })),
      me.role === 'see' ? '' : pauseButton(one)),
    make('p', { class: 'soft' }, [one.template, ...one.arguments.map(([name, value]) => `${name} = ${value}`), runsWords(one)].join(' · '))), language + me.role);
}

function pauseButton({ name, next }) {
  const kind = next === null ? 'resume_timetable' : 'pause_timetable', text = t(next === null ? 'continue' : 'pause');
  return make('button', { 'data-act': 'pause', 'aria-label': `${text} ${name}`, onclick: () => act({ act: kind, name }) }, text);
}
