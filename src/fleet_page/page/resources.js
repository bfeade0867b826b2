// Doors and other devices along their edges; stations, their queues, and machines around their places.
import { makeSvg } from './dom.js';
import { all, entries } from './server.js';
import { t } from './texts.js';
import { ABOVE_FIRST, boxOf } from './placing.js';

export const resourceLayer = makeSvg('g');
const LINE_AWAY = 7; // px from the line of a door to its words
const LEAST = { station: 8, queue: 6, machine: 11 }, SIZES = { station: 0.45, queue: 0.35, machine: 0.62 }; // px and m: half of the width

// Draws all resources again. view: pixel, scale, rem, widthOf, places (for the words), edges and vertices by id.
// Returns the boxes of all words.
export function drawResources(view) {
  const texts = [], shapes = [], squares = new Set(all('machine:').flatMap(([, machine]) => machine.vertices));
  for (const [name, machine] of all('machine:')) shapes.push(drawMachine(name, machine, view, texts));
  for (const [name, resource] of all('resource:')) {
    for (const [k, place] of resource.queue.entries()) shapes.push(drawQueuePlace(name, k + 1, place, view, texts));
    shapes.push(drawResource(name, resource, view, texts, squares));
  }
  resourceLayer.replaceChildren(...shapes.filter(Boolean));
  return placeTexts(texts, view);
}

// Returns the places of a station or group if a mission may name it; empty for a station with places that are not equal.
export function stationPlaces(name) {
  const station = entries.get(`resource:${name}`);
  return station && station.kind === 'STATION' && (station.is_group || station.vertices.length === 1) ? station.vertices : [];
}

const halfOf = (kind, view) => Math.max(LEAST[kind], SIZES[kind] * view.scale);

// Returns the mark around each marked vertex, by vertex: 'station', 'queue' or 'machine'.
export function marksAround() {
  const marks = new Map();
  for (const [, { queue, vertices }] of all('resource:')) {
    for (const { vertex } of queue) marks.set(vertex, 'queue');
    for (const vertex of vertices) marks.set(vertex, 'station');
  }
  for (const [, machine] of all('machine:')) for (const vertex of machine.vertices) marks.set(vertex, 'machine');
  return marks;
}

// Returns the distance (px) from a vertex to the outer edge of the mark around it; 0: there is no mark.
export const reachOf = (mark, scale) => mark ? halfOf(mark, { scale }) : 0;

// Texts are placed in this order: names of stations, doors and machines, then names of queue places. They cover rings only
// if there is no other place.
function placeTexts(texts, view) {
  const boxes = [];
  for (const [id, mark] of marksAround()) {
    const vertex = view.vertices.get(id), half = halfOf(mark, view) * Math.SQRT1_2;
    if (!vertex) continue;
    const [x, y] = view.pixel(vertex[1], vertex[2]);
    view.places.cover([x - half, y - half, x + half, y + half], true);
  }
  for (const { group, words, x, y, away } of texts.sort((a, b) => b.isFirst - a.isFirst)) {
    const text = { x, y, away, width: view.widthOf(words), height: 0.95 * view.rem, may: 'soft' }, side = view.places.place(text, ABOVE_FIRST);
    if (side < 0) continue;
    const box = boxOf(text, ABOVE_FIRST[side]), label = makeSvg('text', { x: ((box[0] + box[2]) / 2).toFixed(1), y: ((box[1] + box[3]) / 2).toFixed(1), 'text-anchor': 'middle', 'dominant-baseline': 'central' });
    label.textContent = words;
    group.append(label);
    boxes.push(box);
  }
  return boxes;
}

function groupOf(kind, name, words) {
  const group = makeSvg('g', { class: kind, role: 'img', 'aria-label': words, 'data-name': name }), title = makeSvg('title');
  title.textContent = words;
  group.append(title);
  return group;
}

// squares: vertices with a machine; the words are outside the machine's square.
function drawResource(name, resource, view, texts, squares) {
  const shown = resourceWords(name, resource), words = resource.robots.length ? `${shown} (${resource.robots.join(', ')})` : shown;
  const isStation = resource.kind === 'STATION', group = groupOf(`resource ${resource.look}${isStation ? ' station' : ''}`, name, words), middles = [];
  for (const edge of resource.edges.map(id => view.edges.get(id)).filter(Boolean)) {
    const points = [];
    for (let k = 0; k < edge[3].length; k += 2) points.push(view.pixel(edge[3][k], edge[3][k + 1]));
    group.append(makeSvg('path', { d: `M${points.map(point => point.map(v => v.toFixed(1)).join(' ')).join('L')}` }));
    coverLine(points, view.places);
    middles.push(points.length === 2 ? [0, 1].map(k => (points[0][k] + points[1][k]) / 2) : points[points.length >> 1]);
  }
  for (const vertex of resource.vertices.map(id => view.vertices.get(id)).filter(Boolean)) middles.push(ring(group, 'station', vertex, view));
  if (middles.length) texts.push({ group, words: shown, x: middles[0][0], y: middles[0][1], away: resource.edges.length ? LINE_AWAY : halfOf(squares.has(resource.vertices[0]) ? 'machine' : 'station', view) + 3, isFirst: true });
  return group;
}

// Keeps words away from the line of a door.
function coverLine(points, places) {
  for (let k = 1; k < points.length; k += 1) {
    const [from, to] = [points[k - 1], points[k]], parts = Math.ceil(Math.hypot(to[0] - from[0], to[1] - from[1]) / (2 * LINE_AWAY));
    for (let part = 0; part <= parts; part += 1) {
      const [x, y] = [0, 1].map(axis => from[axis] + (to[axis] - from[axis]) * part / Math.max(1, parts));
      places.cover([x - LINE_AWAY, y - LINE_AWAY, x + LINE_AWAY, y + LINE_AWAY]);
    }
  }
}

function ring(group, kind, vertex, view) {
  const [x, y] = view.pixel(vertex[1], vertex[2]);
  group.append(makeSvg('circle', { cx: x.toFixed(1), cy: y.toFixed(1), r: halfOf(kind, view).toFixed(1) }));
  return [x, y];
}

function drawQueuePlace(station, number, { vertex, robot, is_there: isThere }, view, texts) {
  const known = view.vertices.get(vertex), state = !robot ? 'FREE' : isThere ? 'TAKEN' : 'COMING';
  if (!known) return null;
  const words = t(`queue_${state}`, { station, number, robot }), group = groupOf(`resource PLACE queue ${state}`, `${station} ${number}`, words);
  const [x, y] = ring(group, 'queue', known, view);
  texts.push({ group, words, x, y, away: halfOf('queue', view) + 3, isFirst: false });
  return group;
}

function drawMachine(name, machine, view, texts) {
  const known = machine.vertices.map(id => view.vertices.get(id)).filter(Boolean);
  if (!known.length) return null;
  const shown = `${t('machine')} ${name}: ${t(`machine_${machine.state}`)}`, half = halfOf('machine', view);
  const group = groupOf(`resource ${machine.look} machine`, name, machine.robot ? `${shown} (${machine.robot})` : shown);
  for (const vertex of known) {
    const [x, y] = view.pixel(vertex[1], vertex[2]);
    group.append(makeSvg('rect', { x: (x - half).toFixed(1), y: (y - half).toFixed(1), width: (2 * half).toFixed(1), height: (2 * half).toFixed(1) }));
  }
  const [x, y] = view.pixel(known[0][1], known[0][2]);
  texts.push({ group, words: shown, x, y, away: half + 3, isFirst: true });
  return group;
}

function resourceWords(name, resource) {
  const what = `${t(`resource_${resource.kind}`)} ${name}`;
  return resource.device ? `${what}: ${t(`device_${resource.device}`)}` : what;
}
