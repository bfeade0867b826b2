// The history: always as tables, and also as charts if the operating system has Chart.js.
import { $, showTable } from './dom.js';
import { get } from './server.js';
import { t, dateOf, duration } from './texts.js';
import { colourOf, drawnEdge, showHeat } from './map.js';

let charts = [], library = null;

export function startHistory() {
  $('load_history').onclick = loadHistory;
  $('hours').onchange = () => { $('csv').href = `/api/history.csv?hours=${$('hours').value}`; loadHistory(); };
}

function chartLibrary() {
  library = library || new Promise(done => {
    const script = document.createElement('script');
    script.src = '/chart.js';
    script.onload = () => done(window.Chart || null);
    script.onerror = () => done(null);
    document.head.append(script);
  });
  return library;
}

export async function loadHistory() {
  const hours = $('hours').value;
  try {
    const values = await get(`/api/history?hours=${hours}`);
    $('history_trouble').textContent = values.trouble;
    showTables(values);
    showHeat(values.edges);
    drawCharts(await chartLibrary(), values);
  } catch (error) { $('history_trouble').textContent = error.message; }
}

function showTables(values) {
  const states = ['SUCCEEDED', 'FAILED', 'CANCELLED', 'EXPIRED'];
  const busy = values.hours.filter(hour => states.some(state => hour[state]));
  showTable($('hours_table'), [t('hour'), ...states.map(state => t(`mission_${state}`))],
    busy.map(hour => [dateOf(hour.begin), ...states.map(state => hour[state])]));
  showTable($('robots_table'), [t('robot'), t('missions'), t('utilisation'), t('waiting'), t('distance')],
    values.robots.map(one => [one.robot, one.missions, `${Math.round(100 * one.utilisation)} %`, duration(one.waiting), `${one.distance} m`]));
  const waited = new Map(); // by edge of the user's graph
  for (const [edge, seconds] of values.edges) waited.set(drawnEdge(edge), (waited.get(drawnEdge(edge)) || 0) + seconds);
  const most = [...waited].sort((a, b) => b[1] - a[1]).slice(0, 20);
  showTable($('heat_table'), [t('edge'), t('waiting')], most.map(([edge, seconds]) => [edge, duration(seconds)]));
}

function drawCharts(Chart, values) {
  for (const chart of charts) chart.destroy();
  charts = [];
  for (const id of ['hours_chart', 'robots_chart']) $(id).hidden = !Chart;
  if (!Chart) return;
  const ink = getComputedStyle(document.documentElement).getPropertyValue('--ink').trim();
  Chart.defaults.color = ink;
  Chart.defaults.animation = false;
  const bars = (id, labels, datasets, title) => charts.push(new Chart($(id), {
    type: 'bar', data: { labels, datasets }, options: { plugins: { title: { display: true, text: title }, legend: { display: datasets.length > 1 } }, scales: { y: { beginAtZero: true, ticks: { precision: 0 } } } } }));
  bars('hours_chart', values.hours.map(hour => new Date(hour.begin * 1000).getHours()), [
    { label: t('mission_SUCCEEDED'), data: values.hours.map(hour => hour.SUCCEEDED), backgroundColor: '#2f8f4e', stack: 'a' },
    { label: t('mission_FAILED'), data: values.hours.map(hour => hour.FAILED), backgroundColor: '#c0392b', stack: 'a' },
    { label: t('mission_CANCELLED'), data: values.hours.map(hour => hour.CANCELLED), backgroundColor: '#8a8f98', stack: 'a' },
    { label: t('mission_EXPIRED'), data: values.hours.map(hour => hour.EXPIRED), backgroundColor: '#d08a1d', stack: 'a' }], t('missions_per_hour'));
  bars('robots_chart', values.robots.map(one => one.robot), [
    { label: t('utilisation_percent'), data: values.robots.map(one => Math.round(100 * one.utilisation)), backgroundColor: values.robots.map(one => colourOf(one.robot)) }], t('per_robot'));
}

export function leaveHistory() { showHeat(null); }
