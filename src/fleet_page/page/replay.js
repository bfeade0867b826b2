// The replay of the last hours: for the slider's time, it draws each robot and the reason why it waited.
import { $, make, showRows } from './dom.js';
import { get } from './server.js';
import { t, dateOf, timeOf } from './texts.js';
import { robotWords, showPast } from './map.js';
import { colourDot } from './robots.js';

let wanted = null, busy = false, playing = null;

export function startReplay() {
  $('moment').addEventListener('input', () => show(Number($('moment').value)));
  $('live').onclick = leaveReplay;
  $('play').onclick = () => playing ? pause() : play();
}

export async function enterReplay() {
  const { span } = await get('/api/replay').catch(() => ({ span: null }));
  $('moment').disabled = $('play').disabled = !span;
  if (!span) { $('moment_time').textContent = t('no_replay'); return; }
  const slider = $('moment');
  slider.min = Math.ceil(span[0]); slider.max = Math.floor(span[1]);
  if (wanted === null) { slider.value = slider.max; $('moment_time').textContent = dateOf(span[1]); }
}

// If the slider moves faster than answers come, only the newest moment is requested.
async function show(time) {
  wanted = time;
  $('moment_time').textContent = dateOf(time);
  $('moment').setAttribute('aria-valuetext', dateOf(time));
  if (busy) return;
  busy = true;
  while (wanted !== null) {
    const asked = wanted;
    const { moment } = await get(`/api/replay?time=${asked}`).catch(() => ({ moment: null }));
    if (wanted === null) break;
    if (moment) {
      showPast(moment);
      $('past').hidden = false;
      $('past').textContent = t('past', { time: timeOf(asked) });
      showRows($('past_robots'), Object.entries(moment.r), ([name]) => name, ([name, [, , , state, waits, works]]) => make('li', {}, colourDot(name), make('b', {}, name), ` ${robotWords({ state, waits_for: waits, works: Boolean(works) })}`));
    }
    if (wanted === asked) break;
  }
  busy = false;
}

function play() {
  playing = setInterval(() => {
    const slider = $('moment');
    if (Number(slider.value) >= Number(slider.max)) { pause(); return; }
    slider.value = Number(slider.value) + 2;
    show(Number(slider.value));
  }, 200);
  $('play').textContent = t('halt');
}

function pause() {
  clearInterval(playing);
  playing = null;
  $('play').textContent = t('play');
}

export function leaveReplay() {
  if (playing) pause();
  wanted = null;
  $('past').hidden = true;
  $('past_robots').replaceChildren();
  $('past_robots').shownRows = null;
  showPast(null);
}
