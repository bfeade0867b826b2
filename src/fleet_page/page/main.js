// The frame of the page: login, tabs, robots, edges, alarms, and the answers to acts.
import { $, make, openMenu, showRows } from './dom.js';
import { entries, follow, get, heardAt, loadSite, makeWay, post, site, unfollow } from './server.js';
import { dateOf, duration, language, momentOf, preferred, said, store, stored, t, timeOf, useLanguage } from './texts.js';
import { leaveLayers, refresh, showHint, showLayerNames, startLayers, wantedStreams } from './layers.js';
import { drawMoving, drawnEdge, knowsEdge, redraw, siteChanged, startMap } from './map.js';
import { choosePlace, showMissions, showPlaces, startMissions } from './missions.js';
import { GROUPS, choose, noteFollowed, showGroup, showRobots, startRobots } from './robots.js';
import { showAlarms, showFold, startAlarms, uncoverPanel } from './alarms.js';
import { leaveHistory, loadHistory, startHistory } from './history.js';
import { enterReplay, leaveReplay, startReplay } from './replay.js';

const TABS = ['missions', 'robots', 'edges', 'history', 'replay', 'audit'];
const SILENT = 12000; // ms without a message after which the server counts as lost; it sends a message every 5 s
const BEGAN = Date.now();
let me = { role: null, login: false }, tab = 'missions', shownSite = null, sayTimer = null, ageShown = 0;

async function act(values) {
  const outcome = await post('/api/act', values);
  if (outcome.status === 401) showLogin();
  say(`${t(`act_${values.act}`)}: ${outcome.ok ? said(outcome.text) || t('done') : `${t('not_done')}: ${said(outcome.text)}`}`);
  return outcome.ok;
}
act.say = say;

function say(text) {
  $('said').hidden = false;
  $('said').textContent = text;
  clearTimeout(sayTimer);
  sayTimer = setTimeout(() => { $('said').hidden = true; }, 12000);
}

// -- sessions ------------------------------------------------------------------------------

function showLogin() {
  unfollow();
  me = { role: null, login: true };
  showStop();
  showCounts();
  $('fleet').hidden = $('logout').hidden = true;
  $('stop').disabled = $('resume').disabled = true;
  $('login').hidden = false;
  $('token').focus();
}

function begin() {
  $('login').hidden = true;
  $('fleet').hidden = false;
  $('logout').hidden = !me.login;
  $('stop').disabled = $('resume').disabled = me.role === 'see';
  for (const element of document.querySelectorAll('.operate')) element.hidden = me.role === 'see';
  $('tab_button_audit').hidden = me.role === 'see';
  followIfShown();
}

// A page that is not visible has no connection, because the browser has only six connections for all its pages.
function followIfShown() {
  if (document.hidden) unfollow();
  else if (me.role) follow(wantedStreams, changed, showLogin);
}

async function login(event) {
  event.preventDefault();
  const answer = await post('/api/login', { token: $('token').value });
  $('token').value = '';
  if (answer.role) { me = answer; $('login_said').textContent = ''; begin(); }
  else $('login_said').textContent = answer.text;
}

// -- messages of the server --------------------------------------------------------------------

// Called when the layers of the map have changed: requests other events, or only draws the map again.
function layersChanged(needsStream) {
  if (needsStream) followIfShown();
  redraw();
}

let pending = new Set(), listsDue = false, isShown = false;
function changed(keys) {
  if (keys === null) pending = null;
  else if (pending) for (const key of keys) pending.add(key);
  requestAnimationFrame(drawChanges);
  if (!listsDue) { listsDue = true; setTimeout(() => { listsDue = false; isShown = true; showLists(); }, isShown ? 250 : 0); }
}

function drawChanges() {
  if (pending && !pending.size) return;
  const keys = pending;
  pending = new Set();
  if (entries.get('site') !== shownSite) {
    shownSite = entries.get('site');
    loadSite().then(() => { siteChanged(); showPlaces(site.vertices); showEdges(); refresh(); }, () => { shownSite = null; });
  }
  if (!keys || keys.has('closed') || keys.has('areas')) redraw();
  showStop();
  drawMoving(keys);
  showLink();
}

function showLink() {
  const fleet = entries.get('fleet') || {}, now = Date.now();
  const isCut = Boolean(me.role) && now - (heardAt || BEGAN) > SILENT, isDead = Boolean(me.role && heardAt) && !fleet.alive;
  const words = isCut ? t('no_server', { age: duration((now - (heardAt || BEGAN)) / 1000) }) : !isDead ? '' : fleet.heard ? t('dead', { time: timeOf(fleet.heard), age: duration(now / 1000 - fleet.heard) }) : t('never_heard');
  const state = words ? t('not_connected') : heardAt ? t('connected') : '';
  if ($('link').textContent !== state) $('link').textContent = state;
  $('link').className = words ? 'bad' : '';
  if ($('old_state').textContent !== words) $('old_state').textContent = words;
  $('old_state').hidden = !words;
  $('moving').classList.toggle('stale', isCut || isDead);
}

// The title of the window shows a stop, so that people see it even if another tab is in front.
function showStop() {
  const stop = me.role && entries.get('stop');
  const words = stop ? [t('stopped'), stop.since ? t('stopped_since', { time: momentOf(stop.since) }) : '', stop.by ? t('stopped_by', stop) : '', stop.why ? t('stopped_why', { why: said(stop.why) }) : '', '. '].join('') : '';
  const whole = words && words + t('stopped_until');
  if ($('stopped').textContent !== whole) $('stopped').replaceChildren(words, make('span', {}, whole && t('stopped_until')));
  $('stopped').hidden = !stop;
  $('resume').classList.toggle('main', Boolean(stop));
  document.title = stop ? t('title_stopped') : t('title');
}

function showLists() {
  showCounts();
  showHint();
  showPlaces(site.vertices);
  showMissions(me);
  showRobots(me);
  showEdges();
  showAreas();
  showAlarms(me);
}

// Shows the numbers of robots and missions. A click on a number opens the list of the robots or missions that it counts.
function showCounts() {
  const counts = me.role && entries.get('counts');
  const opens = { open: () => openTab('missions'), done: () => openTab('history') };
  showRows($('counts'), counts ? [...GROUPS, 'open', 'done'].map(name => ({ name, count: counts[name] })) : [], one => one.name, ({ name, count }) => make('li', {},
    make('button', { 'data-act': name, class: ['count', name, count ? '' : 'none'].filter(Boolean).join(' '), onclick: opens[name] || (() => { openTab('robots'); showGroup(name); }) },
      make('b', {}, String(count)), ' ', make('span', {}, t(`count_${name}`)))), language);
}

function showEdges() {
  showRows($('closed'), [...new Set((entries.get('closed') || []).map(drawnEdge))], edge => edge, edge => make('li', { class: 'row' }, `${t('edge')} ${edge}`,
    me.role === 'see' ? '' : make('button', { 'data-act': 'open', 'aria-label': `${t('open')} ${edge}`, onclick: () => act({ act: 'open', edges: [edge] }) }, t('open'))), language + me.role);
}

// An area is closed if all of its edges are closed.
function showAreas() {
  const closed = new Set((entries.get('closed') || []).map(drawnEdge));
  const areas = Object.entries(entries.get('areas') || {}).map(([name, { edges }]) => ({ name, edges, shut: edges.filter(edge => closed.has(edge)).length }));
  const state = ({ edges, shut }) => t(!shut ? 'area_open' : shut === edges.length ? 'area_closed' : 'area_partly', { shut, whole: edges.length });
  const button = (area, kind, text, values) => make('button', { 'data-act': kind, 'aria-label': `${t(text)} ${area.name}`, onclick: () => act({ act: kind, ...values }) }, t(text));
  showRows($('areas'), areas, area => area.name, area => make('li', { class: 'row' }, make('span', {}, make('b', {}, area.name), ` · ${t('edge')} ${area.edges.join(', ')} · `, make('span', { class: area.shut ? 'bad' : 'soft' }, state(area))),
    ...me.role === 'see' ? [] : [button(area, 'close', 'close', { edges: area.edges }), button(area, 'open', 'open', { edges: area.edges }), button(area, 'remove_area', 'remove', { name: area.name })]), language + me.role);
}

// Shows the acts of an area beside its name after a click on the name.
function chooseArea(name, label) {
  const { edges } = (entries.get('areas') || {})[name] || { edges: [] };
  openTab('edges');
  [...$('areas').children].find(row => row.dataset.key === name)?.scrollIntoView({ block: 'nearest' });
  if (me.role === 'see') return;
  openMenu(label, ['close', 'open'].map(kind => [kind, `${t(kind)} ${name}`, () => act({ act: kind, edges })]));
}

// A click on the map adds an edge to the typed edges, or removes it from them.
function toggleEdge(edge) {
  const typed = $('edge').value.split(/[\s,]+/).filter(Boolean), text = String(edge);
  $('edge').value = (typed.includes(text) ? typed.filter(one => one !== text) : [...typed, text]).join(' ');
}

async function actOnEdges(kind, edges) {
  if (await act({ act: kind, edges })) $('edge').value = '';
}

function edgesTyped() {
  const edges = $('edge').value.split(/[\s,]+/).filter(Boolean).map(Number);
  if (edges.length && edges.every(knowsEdge)) return edges;
  say(t('no_edge'));
  return null;
}

// -- tabs --------------------------------------------------------------------------------------

function makeTabs() {
  for (const name of TABS) {
    $('tabs').append(make('button', { role: 'tab', id: `tab_button_${name}`, 'data-t': `tab_${name}`, 'aria-controls': `tab_${name}`, onclick: () => openTab(name) }));
  }
  $('tabs').addEventListener('keydown', event => {
    const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
    if (!step) return;
    const there = TABS.filter(name => !$(`tab_button_${name}`).hidden);
    openTab(there[(there.indexOf(tab) + step + there.length) % there.length]);
    $(`tab_button_${tab}`).focus();
  });
}

function openTab(name) {
  showTab(name);
  uncoverPanel();
  leaveLayers();
}

function showTab(name) {
  if ($('fleet').dataset.panel === 'folded') showPanel('open');
  if (tab === 'history' && name !== tab) leaveHistory();
  if (tab === 'replay' && name !== tab) leaveReplay();
  tab = name;
  for (const other of TABS) {
    $(`tab_${other}`).hidden = other !== name;
    $(`tab_button_${other}`).setAttribute('aria-selected', String(other === name));
    $(`tab_button_${other}`).tabIndex = other === name ? 0 : -1;
  }
  if (name === 'history') loadHistory();
  if (name === 'replay') enterReplay();
  if (name === 'audit') loadAudit();
}

// The panel beside the map: open, wide or folded. This browser keeps the state.
function showPanel(state) {
  store('panel', state);
  $('fleet').dataset.panel = state;
  $('fold').firstElementChild.textContent = state === 'folded' ? '⟨' : '⟩';
  $('fold').setAttribute('aria-label', t(state === 'folded' ? 'unfold' : 'fold'));
  $('fold').setAttribute('aria-expanded', String(state !== 'folded'));
  $('widen').setAttribute('aria-pressed', String(state === 'wide'));
  showFold();
}

async function loadAudit() {
  const { rows } = await get('/api/audit').catch(() => ({ rows: [] }));
  $('audit').replaceChildren(...rows.map(row => make('li', {},
    make('b', {}, row.person), ` · ${[dateOf(row.time), t(`act_${row.act}`), detailWords(row.details)].filter(Boolean).join(' · ')}`,
    make('p', { class: row.ok ? 'soft' : 'bad' }, `${row.ok ? '' : `${t('not_done')}: `}${becameWords(row.outcome)}`))));
}

const HIDDEN = ['step']; // a number that means nothing to people
const DETAILS = { mission: 'mission', destinations: 'add_destination', stays: 'stay', edges: 'edge', robot: 'robot', robot_type: 'robot_type', priority: 'priority' };
function detailWords(details) {
  const shown = (name, value) => name === 'answer' ? t(`answer_${value}`) : name === 'arguments' ? value.map(pair => pair.join(' = ')).join(', ') : `${DETAILS[name] ? `${t(DETAILS[name])} ` : ''}${[value].flat().join(' ')}`;
  return Object.entries(details).filter(([name]) => !HIDDEN.includes(name)).map(([name, value]) => shown(name, value)).join(', ');
}

// The outcome of a mission has the form STATE robot: reason.
function becameWords(outcome) {
  const [, state, robot, reason] = /^([A-Z]{4,})(?: ([^\s:]+))?(?:: (.*))?$/s.exec(outcome) || [];
  return state && t(`mission_${state}`) !== `mission_${state}` ? [t(`mission_${state}`), robot, reason && said(reason)].filter(Boolean).join(' · ') : said(outcome);
}

function setTheme(name) {
  const dark = name ? name === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  document.documentElement.dataset.theme = dark ? 'dark' : 'light';
  redraw();
}

async function setLanguage(name) {
  await useLanguage(name);
  $('language').value = language;
  for (const element of [$('stop'), $('resume')]) element.title = element.textContent;
  $('widen').title = t('widen');
  showLayerNames();
  showLists(); drawMoving(null); showLink(); showStop(); showPanel($('fleet').dataset.panel);
}

async function main() {
  makeTabs();
  showTab('missions');
  showPanel(stored('panel') || 'open');
  $('fold').onclick = () => showPanel($('fleet').dataset.panel === 'folded' ? 'open' : 'folded');
  $('widen').onclick = () => showPanel($('fleet').dataset.panel === 'wide' ? 'open' : 'wide');
  startMissions(act); startRobots(act); startAlarms(act); startHistory(); startReplay(); startLayers(layersChanged);
  const goTo = place => { if (me.role !== 'see') { openTab('missions'); choosePlace(place); } };
  startMap({ vertex: goTo, station: goTo,
    edge: edge => { openTab('edges'); toggleEdge(edge); }, area: chooseArea, robot: name => { openTab('robots'); choose(name); }, followed: noteFollowed });
  $('stop').onclick = () => { makeWay(); act({ act: 'stop' }); };
  $('resume').onclick = () => act({ act: 'resume' });
  $('edges').addEventListener('submit', event => { event.preventDefault(); const edges = edgesTyped(); if (edges) actOnEdges('close', edges); });
  $('area').addEventListener('submit', async event => {
    event.preventDefault();
    const edges = edgesTyped();
    if (edges && await act({ act: 'add_area', name: $('area_name').value.trim(), edges: [...new Set(edges.map(drawnEdge))] })) $('area_name').value = $('edge').value = '';
  });
  $('open_edge').onclick = () => { const edges = edgesTyped(); if (edges) actOnEdges('open', edges); };
  $('load_audit').onclick = loadAudit;
  $('login').addEventListener('submit', login);
  $('logout').onclick = async () => { await post('/api/logout', {}); location.reload(); };
  $('language').onchange = () => { store('language', $('language').value); setLanguage($('language').value); };
  $('theme').onclick = () => { const name = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark'; store('theme', name); setTheme(name); };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => setTheme(stored('theme')));
  document.addEventListener('visibilitychange', followIfShown);
  setTheme(stored('theme'));
  await setLanguage(preferred());
  setInterval(showLink, 1000);
  me = await get('/api/me');
  if (me.role) begin(); else showLogin();
}

main();
