// The layers of the map, and their menu, which also explains the colours. This browser keeps the choice. The server
// sends a layer's entries, or the page asks for its data, only while the layer is shown.
import { $, make, narrow } from './dom.js';
import { entries, get } from './server.js';
import { store, stored, t } from './texts.js';

export const LAYERS = ['plan', 'areas', 'allocation', 'laser', 'heat', 'fences'];
const AT_FIRST = ['plan', 'areas'];
const STREAMS = ['plan', 'allocation']; // keys of entries begin with these names, or with `laser` and the name of a robot
const KEY = ['dock', 'parking', 'closed']; // what the map shows without a layer
const FRESH = 60000; // ms after which the page asks for the heat map again
const HOURS = 24; // hours that the heat map shows
let shown = new Set(readStored()), changed = null, laserOf = '';
const asked = { heat: { at: 0, of: null, values: null }, fences: { at: 0, of: null, values: null } };

function readStored() {
  const text = stored('layers');
  return text === null ? AT_FIRST : text.split(' ').filter(name => LAYERS.includes(name));
}

export const hasLayer = name => shown.has(name);
export const layerValues = name => (shown.has(name) && asked[name].values) || [];

// Returns the part of the events' address that says which layers the server sends.
export function wantedStreams() {
  const names = STREAMS.filter(name => shown.has(name));
  return `layers=${names.join(',')}${shown.has('laser') && laserOf ? `&laser=${encodeURIComponent(laserOf)}` : ''}`;
}

// given(needsStream) is called when the layers have changed; needsStream: the server must send other events.
export function startLayers(given) {
  changed = given;
  $('layers_button').onclick = () => showMenu($('layers').hidden);
  $('layers').addEventListener('keydown', event => { if (event.key === 'Escape') { showMenu(false); $('layers_button').focus(); } });
  setInterval(refresh, 5000);
}

// On a narrow screen the menu covers the panel.
export function leaveLayers() {
  if (narrow.matches) showMenu(false);
}

function showMenu(isOpen) {
  $('layers').hidden = !isOpen;
  $('layers_button').setAttribute('aria-expanded', String(isOpen));
  if (isOpen) $('layers').querySelector('input').focus();
}

export function showLayerNames() {
  const box = name => {
    const input = make('input', { type: 'checkbox', name, 'data-layer': name });
    input.checked = shown.has(name);
    input.onchange = () => toggle(name, input.checked);
    return make('li', {}, make('label', {}, input, make('i', { class: `key ${name}`, 'aria-hidden': 'true' }), ` ${t(`layer_${name}`)}`));
  };
  $('layer_list').replaceChildren(...LAYERS.map(box), ...KEY.map(name => make('li', { class: 'fixed' }, make('i', { class: `key ${name}`, 'aria-hidden': 'true' }), ` ${t(`key_${name}`)}`)));
  showHint();
}

// Shows the laser of the chosen robot.
export function showLaserOf(robot) {
  if (laserOf === robot) return;
  laserOf = robot;
  showHint();
  if (changed) changed(shown.has('laser'));
}

export function showHint() {
  const words = !shown.has('laser') ? '' : !laserOf ? t('laser_choose') : entries.has(`laser:${laserOf}`) ? '' : t('laser_none', { robot: laserOf });
  if ($('layer_hint').textContent !== words) $('layer_hint').textContent = words;
}

function toggle(name, isOn) {
  if (isOn) shown.add(name); else shown.delete(name);
  store('layers', [...shown].join(' '));
  showHint();
  changed(STREAMS.includes(name) || name === 'laser');
  refresh();
}

// Asks for the data that the server sends as answers: the heat map of the last hours, and the fences of the site.
export function refresh() {
  ask('heat', FRESH, `/api/history?hours=${HOURS}`, answer => answer.edges);
  ask('fences', Infinity, '/api/fences', answer => answer.fences);
}

async function ask(name, fresh, path, valuesOf) {
  const known = asked[name], of = entries.get('site');
  if (!shown.has(name) || of === undefined || document.hidden || (known.of === of && Date.now() - known.at < fresh)) return;
  Object.assign(known, { of, at: Date.now() });
  const answer = await get(path).catch(() => null);
  if (!answer) { known.of = null; return; }
  known.values = valuesOf(answer);
  changed(false);
}
