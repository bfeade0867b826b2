// The map: fixed objects on a canvas, moving objects as SVG with names for screen readers.
import { $, makeSvg } from './dom.js';
import { entries, all, site } from './server.js';
import { language, said, t } from './texts.js';
import { ABOVE_FIRST, BELOW_RIGHT_FIRST, Places, boxOf } from './placing.js';
import { drawResources, marksAround, reachOf, resourceLayer, stationPlaces } from './resources.js';
import { Walls } from './walls.js';
import { hasLayer, layerValues, showLaserOf } from './layers.js';

const REACH = 16; // px from a vertex within which a click selects the vertex
const NAMES_FROM = 12, BATTERY_FROM = 20; // px per m from which on all vertices show their names, and robots their charge
const MARGIN = { x: 45, y: 35, rem: 3 }; // px around the site; rem above it for the bar of a stop, and below it for alarms on the map
const GOLDEN = 0.618034; // as in rviz_drawing: each new hue is far from all earlier ones
const TROUBLE = ['STOPPED', 'TAKEN_OVER', 'FAILED', 'OFF_GRAPH', 'UNKNOWN'];
const GONE = ['OFFLINE', 'OUT_OF_SERVICE', 'ABSENT'];
const canvas = $('site'), svg = $('moving');
const view = { x: 0, y: 0, scale: 20 }; // centre of the view in m, pixels per m
const edgesById = new Map(), verticesById = new Map(), robots = new Map();
let drawnEdges = new Set(); // ids of the edges that the user drew; an edge of the graph may be a section of such an edge
let walls = null, handlers = {}, heat = null, chosen = [], chosenRobot = '', past = null, drawn = 0;
let isFree = false; // whether the user has moved the view; it then stays when the window changes
let rem = 16; // px; larger on a wall screen
let followed = '', fixed = [], words = []; // the robot in the middle of the view; the boxes of vertices and their names; the boxes of the words of resources
let areaSigns = []; // the boxes of the areas' names: a robot's label covers such a name only if there is no other place
let buttons = [0, 0, 0, 0]; // the box of the buttons in the map
let shownMarks = ''; // the marks around vertices, which the names of the vertices avoid

const hidden = { 'aria-hidden': 'true' };
const allocationLayer = makeSvg('g', { ...hidden, class: 'allocations' }), planLayer = makeSvg('g', hidden), laserLayer = makeSvg('path', { ...hidden, class: 'laser' });
const areaLayer = makeSvg('g', { id: 'map_areas' }), robotLayer = makeSvg('g');
svg.append(allocationLayer, planLayer, laserLayer, areaLayer, resourceLayer, robotLayer);
const shade = document.createElement('canvas'); // the canvas in which the outlines of areas are made

export function startMap(given) {
  handlers = given;
  new ResizeObserver(() => { if (!isFree) fit(); redraw(); }).observe($('map'));
  $('zoom_in').onclick = () => zoom(1.3);
  $('zoom_out').onclick = () => zoom(1 / 1.3);
  $('zoom_fit').onclick = () => { isFree = false; followRobot(''); fit(); redraw(); };
  $('map').addEventListener('wheel', event => { event.preventDefault(); zoom(event.deltaY < 0 ? 1.15 : 1 / 1.15, event); }, { passive: false });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', redraw);
  followPointers();
}

function followPointers() {
  const held = new Map();
  let moved = 0;
  svg.addEventListener('pointerdown', event => {
    if (!held.size) moved = 0;
    held.set(event.pointerId, [event.clientX, event.clientY]);
  });
  svg.addEventListener('pointermove', event => {
    const before = held.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], shift = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(...shift);
    if (moved < 6) return;
    isFree = true;
    followRobot('');
    if (held.size === 2) {
      const other = [...held].find(([id]) => id !== event.pointerId)[1];
      const size = point => Math.hypot(point[0] - other[0], point[1] - other[1]);
      view.scale *= size(now) / Math.max(1, size(before));
    } else { view.x -= shift[0] / view.scale; view.y += shift[1] / view.scale; }
    held.set(event.pointerId, now);
    redraw();
  });
  for (const kind of ['pointerup', 'pointercancel', 'pointerleave']) {
    svg.addEventListener(kind, event => {
      if (held.delete(event.pointerId) && kind === 'pointerup' && moved < 6) click(event);
    });
  }
}

function click(event) {
  const robot = event.target.closest('.robot'), area = event.target.closest('.area');
  if (robot) { handlers.robot(robot.dataset.name); return; }
  if (area) { handlers.area(area.dataset.key, area); return; }
  const station = event.target.closest('.station text');
  if (station && stationPlaces(station.parentElement.dataset.name).length) { handlers.station(station.parentElement.dataset.name); return; }
  const box = svg.getBoundingClientRect(), at = [event.clientX - box.left, event.clientY - box.top];
  let best = null, least = REACH;
  for (const [id, x, y, kind] of site.vertices) {
    if (kind === 'cut') continue; // it divides an edge, and the user has not drawn it
    const [px, py] = pixel(x, y), away = Math.hypot(px - at[0], py - at[1]);
    if (away < least) { least = away; best = id; }
  }
  if (best !== null) { handlers.vertex(best); return; }
  least = 10;
  for (const [id, , , points] of site.edges) {
    for (let k = 0; k + 3 < points.length; k += 2) {
      const away = distance(at, pixel(points[k], points[k + 1]), pixel(points[k + 2], points[k + 3]));
      if (away < least) { least = away; best = id; }
    }
  }
  if (best !== null) handlers.edge(drawnEdge(best));
}

function distance(p, a, b) {
  const dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
  const part = length ? Math.max(0, Math.min(1, ((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / length)) : 0;
  return Math.hypot(p[0] - a[0] - part * dx, p[1] - a[1] - part * dy);
}

export function siteChanged() {
  edgesById.clear(); verticesById.clear();
  for (const edge of site.edges) edgesById.set(edge[0], edge);
  drawnEdges = new Set(site.edges.map(edge => edge[4]));
  for (const vertex of site.vertices) verticesById.set(vertex[0], vertex);
  walls = null;
  if (site.map) {
    const image = new Image();
    image.onload = () => { walls = new Walls(image, site.map); if (!isFree) fit(); redraw(); };
    image.src = `/api/map.png?${entries.get('site')}`;
  }
  if (!isFree) fit();
  redraw();
}

export function vertexName(id) {
  const vertex = verticesById.get(id);
  return vertex && vertex[4] && vertex[4] !== 'pass' ? `${id} ${vertex[4]}` : String(id);
}

export const knowsVertex = id => verticesById.has(id);
export const knowsEdge = id => edgesById.has(id) || drawnEdges.has(id);
export const drawnEdge = id => edgesById.has(id) ? edgesById.get(id)[4] : id;

function fit() {
  const box = $('map').getBoundingClientRect(), own = $('zoom').getBoundingClientRect();
  const xs = site.vertices.map(v => v[1]), ys = site.vertices.map(v => v[2]);
  if (walls && walls.bounds) { xs.push(walls.bounds[0], walls.bounds[2]); ys.push(walls.bounds[1], walls.bounds[3]); }
  if (!xs.length || !box.width) return;
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  // The site is beside the buttons or above them, depending on where there is more room.
  const news = Math.max(MARGIN.y, MARGIN.rem * parseFloat(getComputedStyle(document.documentElement).fontSize));
  const least = $('fleet').dataset.panel === 'folded' ? news : MARGIN.y;
  const margins = [
    { right: Math.max(MARGIN.x, box.right - own.left + 8), low: least },
    { right: MARGIN.x, low: Math.max(least, box.bottom - own.top + 8) }];
  const [beside, above] = margins.map(margin => Math.min(
    (box.width - MARGIN.x - margin.right) / (right - left + 1), (box.height - news - margin.low) / (high - low + 1), 200));
  const margin = margins[beside > above ? 0 : 1];
  view.scale = Math.max(beside, above);
  view.x = (left + right) / 2 + (margin.right - MARGIN.x) / 2 / view.scale;
  view.y = (low + high) / 2 - (margin.low - news) / 2 / view.scale;
}

function zoom(factor, event) {
  const box = $('map').getBoundingClientRect();
  const dx = event ? event.clientX - box.left - box.width / 2 : 0, dy = event ? event.clientY - box.top - box.height / 2 : 0;
  const before = view.scale;
  isFree = true;
  view.scale = Math.max(0.5, Math.min(500, view.scale * factor));
  view.x += dx / before - dx / view.scale; view.y -= dy / before - dy / view.scale;
  redraw();
}

function pixel(x, y) {
  return [size.width / 2 + (x - view.x) * view.scale, size.height / 2 - (y - view.y) * view.scale];
}

// Returns the position of a vertex in the window; null: there is no such vertex.
export function screenPlace(id) {
  const vertex = verticesById.get(id), box = svg.getBoundingClientRect();
  if (!vertex || size.width < 2) return null;
  const [x, y] = pixel(vertex[1], vertex[2]);
  return [box.left + x, box.top + y];
}

const size = { width: 1, height: 1 };
let waiting = false;
export function redraw() {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; drawSite(); drawAreas(); drawMoving(null); drawn += 1; });
}
export const framesDrawn = () => drawn;

function drawSite() {
  const box = $('map').getBoundingClientRect(), ratio = devicePixelRatio || 1, own = $('zoom').getBoundingClientRect();
  size.width = box.width; size.height = box.height;
  buttons = [own.left - box.left, own.top - box.top, own.right - box.left, own.bottom - box.top];
  if (canvas.width !== Math.round(box.width * ratio) || canvas.height !== Math.round(box.height * ratio)) {
    canvas.width = Math.round(box.width * ratio); canvas.height = Math.round(box.height * ratio);
  }
  const paint = canvas.getContext('2d'), style = getComputedStyle(document.documentElement);
  const colour = name => style.getPropertyValue(`--${name}`).trim();
  rem = parseFloat(style.fontSize);
  paint.setTransform(ratio, 0, 0, ratio, 0, 0);
  paint.clearRect(0, 0, box.width, box.height);
  if (walls) walls.draw(paint, pixel, view.scale, ratio);
  const closed = new Set(entries.get('closed') || []);
  drawFences(paint, colour('fence'));
  outlineAreas(paint, ratio, closed, colour);
  const lines = (edges, width, stroke) => {
    paint.beginPath();
    for (const [, , , points] of edges) {
      paint.moveTo(...pixel(points[0], points[1]));
      for (let k = 2; k < points.length; k += 2) paint.lineTo(...pixel(points[k], points[k + 1]));
    }
    paint.lineWidth = width * rem / 16; paint.strokeStyle = stroke; paint.stroke();
  };
  lines(site.edges.filter(edge => !closed.has(edge[0])), 1.5, colour('edge'));
  const warm = heat || layerValues('heat');
  if (warm.length) {
    const most = Math.max(...warm.map(([, seconds]) => seconds));
    for (const [id, seconds] of warm) {
      const edge = edgesById.get(id);
      if (edge) lines([edge], 3 + 9 * seconds / most, `hsl(${60 - 60 * seconds / most} 95% 50% / .8)`);
    }
  }
  lines(site.edges.filter(edge => closed.has(edge[0])), 5, colour('shut'));
  const radius = Math.max(2, Math.min(rem / 2, view.scale * 0.16));
  for (const [kind, fill] of [['cut', 'edge'], ['vertex', 'edge'], ['parking', 'parking'], ['dock', 'dock']]) {
    paint.beginPath();
    for (const [, x, y, own] of site.vertices) {
      if (own !== kind) continue;
      const [px, py] = pixel(x, y), r = kind === 'cut' ? radius / 2 : kind === 'vertex' ? radius : radius * 1.4;
      if (kind === 'dock' || kind === 'parking') paint.rect(px - r, py - r, 2 * r, 2 * r);
      else { paint.moveTo(px + r, py); paint.arc(px, py, r, 0, 7); }
    }
    paint.fillStyle = colour(fill); paint.fill();
  }
  paint.font = `${0.75 * rem}px system-ui, sans-serif`; paint.fillStyle = colour('soft'); paint.textBaseline = 'middle';
  drawNames(paint, radius);
  paint.textBaseline = 'alphabetic';
  paint.strokeStyle = paint.fillStyle = colour('main'); paint.lineWidth = 3; paint.font = `bold ${0.875 * rem}px system-ui, sans-serif`;
  chosen.forEach((ids, k) => {
    for (const vertex of ids.map(id => verticesById.get(id)).filter(Boolean)) {
      const [px, py] = pixel(vertex[1], vertex[2]);
      paint.beginPath(); paint.arc(px, py, radius + 6, 0, 7); paint.stroke();
      paint.fillText(String(k + 1), px - 4, py - radius - 9);
    }
  });
}

// Draws the fences of the robots' map: areas and lines through which no robot plans a path.
function drawFences(paint, colour) {
  paint.strokeStyle = paint.fillStyle = colour; paint.lineWidth = 2;
  for (const points of layerValues('fences')) {
    paint.beginPath();
    for (let k = 0; k < points.length; k += 2) paint.lineTo(...pixel(points[k], points[k + 1]));
    if (points.length > 4) { paint.closePath(); paint.globalAlpha = 0.18; paint.fill(); paint.globalAlpha = 1; }
    paint.stroke();
  }
}

const shownAreas = () => hasLayer('areas') ? Object.entries(entries.get('areas') || {}) : [];
const edgesOf = ids => site.edges.filter(edge => ids.includes(edge[4]));

// Draws one outline around all edges of each area: a broad line along the edges; the inside of the line is then
// removed.
function outlineAreas(paint, ratio, closed, colour) {
  const areas = shownAreas();
  if (!areas.length) return;
  shade.width = canvas.width; shade.height = canvas.height;
  const own = shade.getContext('2d'), wide = Math.max(14, 1.1 * view.scale);
  own.lineCap = own.lineJoin = 'round';
  own.setTransform(ratio, 0, 0, ratio, 0, 0);
  for (const [, { edges }] of areas) {
    const there = edgesOf(edges), isShut = there.length && there.every(edge => closed.has(edge[0]));
    const draw = (width, alpha) => { own.globalAlpha = alpha; own.lineWidth = width; own.stroke(); };
    own.clearRect(0, 0, size.width, size.height);
    own.strokeStyle = colour(isShut ? 'shut' : 'main');
    own.beginPath();
    for (const [, , , points] of there) {
      own.moveTo(...pixel(points[0], points[1]));
      for (let k = 2; k < points.length; k += 2) own.lineTo(...pixel(points[k], points[k + 1]));
    }
    draw(wide + 3, 1);
    own.globalCompositeOperation = 'destination-out';
    draw(wide, 1);
    own.globalCompositeOperation = 'source-over';
    draw(wide, isShut ? 0.2 : 0.1);
    paint.drawImage(shade, 0, 0, size.width, size.height);
  }
}

// The name of an area is a button at the highest of the area's edges.
function drawAreas() {
  const places = new Places(size.width, size.height), kept = document.activeElement?.closest?.('.area')?.dataset.key;
  coverControls(places);
  for (const box of fixed) places.cover(box);
  areaSigns = [];
  areaLayer.replaceChildren(...shownAreas().map(([name, { edges }]) => {
    const points = edgesOf(edges).flatMap(([, , , own]) => {
      const found = [];
      for (let k = 0; k < own.length; k += 2) found.push(pixel(own[k], own[k + 1]));
      return found.length === 2 ? [[0, 1].map(k => (found[0][k] + found[1][k]) / 2)] : found;
    });
    if (!points.length) return null;
    const [x, y] = points.reduce((best, point) => point[1] < best[1] ? point : best);
    const text = { x, y, away: Math.max(7, 0.55 * view.scale) + 4, width: widthOf(name) + 8, height: 1.15 * rem, may: 'all' };
    const box = boxOf(text, ABOVE_FIRST[places.place(text, ABOVE_FIRST)]), group = makeSvg('g', { class: 'area', role: 'button', tabindex: 0, 'data-key': name, 'aria-label': t('area_acts', { name }) });
    const label = makeSvg('text', { x: ((box[0] + box[2]) / 2).toFixed(1), y: ((box[1] + box[3]) / 2).toFixed(1), 'text-anchor': 'middle', 'dominant-baseline': 'central' });
    areaSigns.push(box);
    label.textContent = name;
    group.append(makeSvg('rect', { x: box[0].toFixed(1), y: box[1].toFixed(1), width: (box[2] - box[0]).toFixed(1), height: (box[3] - box[1]).toFixed(1), rx: 4 }), label);
    group.addEventListener('keydown', event => {
      if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); handlers.area(name, group); }
    });
    return group;
  }).filter(Boolean));
  if (kept) [...areaLayer.children].find(one => one.dataset.key === kept)?.focus();
}

// The names of places are placed first. A name without room is left out until the user zooms in.
function drawNames(paint, radius) {
  const places = new Places(size.width, size.height), texts = [], marks = marksAround();
  fixed = [];
  shownMarks = JSON.stringify([...marks]);
  for (const [id, x, y, kind] of site.vertices) {
    const [px, py] = pixel(x, y), name = vertexName(id), isPlace = kind === 'dock' || kind === 'parking' || name !== String(id);
    if (kind === 'cut' || px < 0 || py < 0 || px > size.width || py > size.height) continue;
    fixed.push([px - radius, py - radius, px + radius, py + radius]);
    if (isPlace || view.scale > NAMES_FROM * rem / 16) texts.push({ name, isPlace, x: px, y: py, away: Math.max(1.4 * radius, reachOf(marks.get(id), view.scale)) + 2, width: paint.measureText(name).width, height: 0.85 * rem });
  }
  coverControls(places);
  for (const box of fixed) places.cover(box);
  for (const text of texts.sort((a, b) => b.isPlace - a.isPlace)) {
    const side = places.place(text, BELOW_RIGHT_FIRST);
    if (side < 0) continue;
    const box = boxOf(text, BELOW_RIGHT_FIRST[side]);
    fixed.push(box);
    paint.fillText(text.name, box[0], (box[1] + box[3]) / 2);
  }
}

// Keeps texts away from the buttons of the map and from the bar of a stop.
function coverControls(places) {
  places.cover(buttons);
  if ($('bars').clientHeight) places.cover([0, 0, size.width, $('bars').clientHeight]);
}

// vertices: one list for each destination; the list of a group has several vertices.
export function showChosen(vertices) { chosen = vertices; redraw(); }
export function showHeat(edges) { heat = edges; redraw(); }
export function chooseRobot(name) { chosenRobot = name; showLaserOf(name); drawMoving(null); }
export function showPast(moment) { past = moment; drawMoving(null); }

// The hue of a robot is the same as in RViz, which counts the robots in the same order.
const hueOf = name => 360 * ((0.55 + ((entries.get(`robot:${name}`) || {}).number || 0) * GOLDEN) % 1);
export const colourOf = name => `hsl(${hueOf(name)} 60% 42%)`;

export function followRobot(name) {
  if (followed === name) return;
  followed = name;
  if (handlers.followed) handlers.followed(name);
  keepInMiddle();
}

function keepInMiddle() {
  const pose = entries.get(`pose:${followed}`);
  if (!pose || past || (view.x === pose[0] && view.y === pose[1])) return;
  isFree = true;
  [view.x, view.y] = pose;
  redraw();
}

// Updates the moving objects; keys: the entries that have changed; null: all entries.
export function drawMoving(keys) {
  if (past) { drawPast(); return; }
  const wanted = new Set();
  for (const [name, robot] of all('robot:')) {
    const pose = entries.get(`pose:${name}`);
    if (!pose || robot.state === 'ABSENT') continue;
    wanted.add(name);
    if (keys && !keys.has(`pose:${name}`) && !keys.has(`robot:${name}`) && robots.has(name)) continue;
    placeRobot(name, pose, robot);
  }
  dropRobots(wanted);
  if (!keys || [...keys].some(key => /^(resource|machine):/.test(key))) {
    drawSiteWork();
    if (shownMarks !== JSON.stringify([...marksAround()])) redraw();
  }
  placeLabels();
  if (followed) keepInMiddle();
  if (!keys || [...keys].some(key => key.startsWith('plan:'))) drawPlans();
  if (!keys || [...keys].some(key => key.startsWith('allocation:'))) drawAllocations();
  if (!keys || [...keys].some(key => key.startsWith('laser:'))) drawLaser();
}

function drawPast() {
  const wanted = new Set();
  for (const [name, [x, y, theta, state, waits, works]] of Object.entries(past.r)) {
    wanted.add(name);
    const known = entries.get(`robot:${name}`) || {};
    placeRobot(name, [x, y, theta], { ...known, state, waits_for: waits, works: Boolean(works), battery: null, destination: 0, load: 'EMPTY' });
  }
  dropRobots(wanted);
  planLayer.replaceChildren(); allocationLayer.replaceChildren(); resourceLayer.replaceChildren(); words = [];
  laserLayer.setAttribute('d', '');
  placeLabels();
}

function dropRobots(wanted) {
  for (const [name, shapes] of robots) if (!wanted.has(name)) { shapes.group.remove(); robots.delete(name); }
}

// A robot's label keeps its side while this side is free. It may cover vertices and other names, but no other robot. A
// label without such a place is left out until the user zooms in. Labels of the chosen robot and of robots in trouble
// are placed first, and are always shown.
function placeLabels() {
  const places = new Places(size.width, size.height);
  coverControls(places);
  for (const box of [...fixed, ...areaSigns, ...words]) places.cover(box, true);
  for (const { x, y, reach } of robots.values()) {
    const half = reach * Math.SQRT1_2;  // the square within its disc; with a larger box, a label at a corner would always cover its own robot
    places.cover([x - half, y - half, x + half, y + half]);
  }
  for (const shapes of [...robots.values()].sort((a, b) => b.isFirst - a.isFirst)) {
    const text = { x: shapes.x, y: shapes.y, away: shapes.reach + 1, width: widthOf(shapes.label), height: 0.95 * rem, may: shapes.isFirst ? 'all' : 'soft' };
    shapes.side = places.place(text, ABOVE_FIRST, shapes.side);
    shapes.text.style.display = shapes.card.style.display = shapes.side < 0 ? 'none' : '';
    if (shapes.side < 0) continue;
    const [left, top, right, bottom] = boxOf(text, ABOVE_FIRST[shapes.side]);
    shapes.text.setAttribute('x', ((left + right) / 2 - shapes.x).toFixed(1));
    shapes.text.setAttribute('y', ((top + bottom) / 2 - shapes.y).toFixed(1));
    for (const [name, value] of [['x', left - shapes.x], ['y', top - shapes.y], ['width', right - left], ['height', bottom - top]]) shapes.card.setAttribute(name, value.toFixed(1));
  }
}

const widths = new Map(), measure = document.createElement('canvas').getContext('2d');
function widthOf(text) {
  const key = `${rem} ${text}`;
  if (!widths.has(key)) {
    if (widths.size > 5000) widths.clear();
    measure.font = `${0.8125 * rem}px system-ui, sans-serif`;
    widths.set(key, measure.measureText(text).width + 4);
  }
  return widths.get(key);
}

function placeRobot(name, [x, y, theta], robot) {
  const shapes = robots.get(name) || newRobot(name);
  const [px, py] = pixel(x, y), radius = Math.max(7, (site.radii[robot.type] || 0.4) * view.scale);
  const turn = theta === null ? 0 : -theta * 180 / Math.PI;
  shapes.group.setAttribute('transform', `translate(${px.toFixed(1)} ${py.toFixed(1)})`);
  shapes.body.setAttribute('transform', `rotate(${turn.toFixed(1)}) scale(${(radius / 10).toFixed(3)})`);
  shapes.nose.style.display = theta === null ? 'none' : '';
  shapes.ring.setAttribute('r', radius + 4);
  const isInTrouble = Boolean(robot.alarm || robot.asks) || TROUBLE.includes(robot.state), isFirst = isInTrouble || name === chosenRobot;
  const label = robot.battery === null || robot.battery === undefined ? name : `${name} ${Math.round(100 * robot.battery)} %`;
  Object.assign(shapes, { x: px, y: py, isFirst, reach: radius + (isFirst ? 5 : 1), label: view.scale < BATTERY_FROM * rem / 16 ? name : label });
  if (shapes.text.textContent !== shapes.label) shapes.text.textContent = shapes.label;
  const kind = ['robot', isInTrouble ? 'trouble' : '', GONE.includes(robot.state) ? 'gone' : '', name === chosenRobot ? 'chosen' : ''].filter(Boolean).join(' ');
  if (shapes.group.getAttribute('class') !== kind) shapes.group.setAttribute('class', kind);
  const load = loadWords(robot), words = `${label}: ${robotWords(robot)}${load && `, ${load}`}`;
  shapes.load.setAttribute('class', `load ${loadState(robot)}`);
  if (shapes.words !== words) { shapes.words = words; shapes.group.setAttribute('aria-label', words); shapes.title.textContent = words; }
}

// While a step takes or gives the load, the place of the load is unknown, but no person has to look for it.
export const loadState = robot => robot.load === 'UNKNOWN' && robot.works ? 'MOVES' : robot.load;

// Returns words for the load of a robot; empty: it carries nothing.
export const loadWords = robot => robot.load === 'EMPTY' ? '' : t(`load_${loadState(robot)}`, { mission: `M${robot.load_serial}` }) + (robot.load_types && robot.load_types.length ? ` (${robot.load_types.join(', ')})` : '');

export function robotWords(robot) {
  const vertex = robot.destination && vertexName(robot.destination), isBusy = robot.state === 'BUSY';
  const asks = robot.asks || robot.alarm === 'LADEN', doing = asks ? t('robot_asks') : robot.works ? (vertex ? t('works_at', { vertex }) : t('robot_working')) : isBusy && vertex ? t('drives_to', { vertex }) : t(`robot_${robot.state}`);
  if (!robot.waits_for) return doing;
  if (robot.works || asks) return `${doing}: ${said(robot.waits_for)}`;
  const why = outageWords(robot);
  if (why.toLowerCase() === doing.toLowerCase()) return doing;
  return [...TROUBLE, ...GONE].includes(robot.state) ? `${doing}: ${why}` : `${doing} (${t('waits_for')}: ${why})`;
}

// Returns why a robot does not work or drive. If no translation of the reason is known, the text of the outage's code
// comes first.
export function outageWords(robot) {
  const words = said(robot.waits_for), code = robot.outage;
  const isForeign = language !== 'en' && words === robot.waits_for && code && !['NONE', 'UNKNOWN'].includes(code);
  return isForeign ? `${t(`outage_${code}`)} („${words}“)` : words;
}

function newRobot(name) {
  const group = makeSvg('g', { class: 'robot', role: 'button', tabindex: 0, 'data-name': name });
  const ring = makeSvg('circle', { class: 'ring', r: 14 }), body = makeSvg('g');
  const load = makeSvg('rect', { x: -8.5, y: -4, width: 8, height: 8, rx: 1 }), nose = makeSvg('path', { d: 'M1,-4 L8,0 L1,4 z', fill: '#fff' }), text = makeSvg('text', { 'text-anchor': 'middle', 'dominant-baseline': 'central' }), title = makeSvg('title');
  body.append(makeSvg('rect', { class: 'body', x: -10, y: -7, width: 20, height: 14, rx: 3, fill: colourOf(name) }), nose, load);
  const card = makeSvg('rect', { class: 'card', rx: 3 });
  group.append(title, card, ring, body, text);
  group.addEventListener('keydown', event => {
    if (event.key === 'Enter' || event.key === ' ') { event.preventDefault(); handlers.robot(name); }
  });
  robotLayer.append(group);
  const shapes = { group, card, ring, body, nose, load, text, title, words: '', side: -1 };
  robots.set(name, shapes);
  return shapes;
}

function drawSiteWork() {
  const places = new Places(size.width, size.height);
  coverControls(places);
  for (const box of [...fixed, ...areaSigns]) places.cover(box);
  words = drawResources({ pixel, places, widthOf, rem, scale: view.scale, edges: edgesById, vertices: verticesById });
}

function drawPlans() {
  const shapes = [];
  for (const [name, [edges, released]] of all('plan:')) {
    const stroke = `hsl(${hueOf(name)} 60% 50%)`;
    const line = part => part.map(signed => {
      const edge = edgesById.get(Math.abs(signed));
      if (!edge) return '';
      const points = [];
      for (let k = 0; k < edge[3].length; k += 2) points.push(pixel(edge[3][k], edge[3][k + 1]).map(v => v.toFixed(1)).join(' '));
      if (signed < 0) points.reverse();
      return `M${points.join('L')}`;
    }).join('');
    if (released) shapes.push(makeSvg('path', { class: 'released', d: line(edges.slice(0, released)), stroke, 'data-robot': name }));
    if (edges.length > released) shapes.push(makeSvg('path', { class: 'plan', d: line(edges.slice(released)), stroke, 'data-robot': name }));
  }
  planLayer.replaceChildren(...shapes);
}

// Draws the places that each robot may occupy, as broad as the robot: the part of each edge that is not behind the
// robot, its vertex, and other places.
function drawAllocations() {
  const shapes = [];
  for (const [name, [holds, vertex, places]] of all('allocation:')) {
    const stroke = colourOf(name), kind = (entries.get(`robot:${name}`) || {}).type, wide = 2 * (site.radii[kind] || 0.4);
    const line = (points, width) => shapes.push(makeSvg('path', { d: `M${points.map(point => point.map(v => v.toFixed(1)).join(' ')).join('L')}${points.length === 1 ? 'h0' : ''}`, stroke, 'stroke-width': (width * view.scale).toFixed(1), 'data-robot': name }));
    for (const [signed, cleared] of holds) {
      const points = partOf(signed, cleared);
      if (points.length) line(points, wide);
    }
    const known = verticesById.get(vertex);
    if (known) line([pixel(known[1], known[2])], wide);
    for (const [radius, points] of places) line(points.map(point => pixel(...point)), Math.max(2 * radius, 0.1));
  }
  allocationLayer.replaceChildren(...shapes);
}

// Returns the points (px) of an edge after the cleared fraction, in driving direction.
function partOf(signed, cleared) {
  const edge = edgesById.get(Math.abs(signed)), points = [];
  if (!edge) return points;
  for (let k = 0; k < edge[3].length; k += 2) points.push(pixel(edge[3][k], edge[3][k + 1]));
  if (signed < 0) points.reverse();
  const steps = points.slice(1).map((point, k) => Math.hypot(point[0] - points[k][0], point[1] - points[k][1]));
  let behind = cleared * steps.reduce((sum, step) => sum + step, 0), k = 0;
  while (k < steps.length - 1 && behind > steps[k]) { behind -= steps[k]; k += 1; }
  const part = steps[k] ? Math.min(1, behind / steps[k]) : 0, [from, to] = [points[k], points[k + 1]];
  return [[0, 1].map(axis => from[axis] + part * (to[axis] - from[axis])), ...points.slice(k + 1)];
}

// Draws the points of the chosen robot's laser: x and y in cm, one after the other.
function drawLaser() {
  const points = entries.get(`laser:${chosenRobot}`) || [];
  let d = '';
  for (let k = 0; k < points.length; k += 2) d += `M${pixel(points[k] / 100, points[k + 1] / 100).map(v => v.toFixed(1)).join(' ')}h0`;
  laserLayer.setAttribute('d', d);
}
