// Alarms: each robot or mission that needs a person, with the remedy, until the cause is gone.
import { $, make, narrow, showRows, withCode } from './dom.js';
import { all, entries } from './server.js';
import { language, momentOf, store, stored, t } from './texts.js';
import { outageWords } from './map.js';
import { answerButtons, reasonWords } from './missions.js';
import { colourDot, fullName } from './robots.js';

const PERIOD = 3000; // ms between two tones
let me = { role: null }, act = null, unseen = 0, audio = null;

export function startAlarms(given) {
  act = given;
  $('fold_alarms').onclick = () => { store(foldKey(), isFolded() ? 'open' : 'folded'); showFold(); };
  $('sound').onclick = () => { store('sound', hasSound() ? 'off' : 'on'); showFold(); };
  narrow.addEventListener('change', showFold);
  setInterval(sound, PERIOD);
}

// On a narrow screen the open list replaces the panel. If the panel is folded, the list covers a part of the map.
const isOnMap = () => $('fleet').dataset.panel === 'folded';
const foldKey = () => isOnMap() ? 'alarms_on_map' : 'alarms';
const isFolded = () => (stored(foldKey()) || (narrow.matches || isOnMap() ? 'folded' : 'open')) === 'folded';
const hasSound = () => stored('sound') !== 'off';

export function uncoverPanel() {
  if (isFolded() || !narrow.matches) return;
  store('alarms', 'folded');
  showFold();
}

export function showAlarms(person) {
  me = person;
  const alarms = all('alarm:').map(([key, alarm]) => ({ key, ...alarm, ...wordsOf(key, alarm) })).sort((a, b) => Boolean(a.seen_by) - Boolean(b.seen_by) || a.since - b.since || a.name.localeCompare(b.name, language, { numeric: true }));
  unseen = me.role ? alarms.filter(alarm => !alarm.seen_by).length : 0;
  showRows($('alarm_list'), alarms, alarm => alarm.key, alarmRow, language + me.role);
  const count = alarms.length ? `(${alarms.length})` : '';
  if ($('alarm_count').textContent !== count) $('alarm_count').textContent = count;
  $('alarms').classList.toggle('unseen', unseen > 0);
  $('alarms').hidden = !alarms.length || !me.role;
  showFold();
}

// The words are in the entry of the robot or mission; the cause is in the alarm.
function wordsOf(key, { cause }) {
  const [kind, ...rest] = key.split(':');
  if (kind === 'robot') {
    const name = rest.join(':');
    const robot = entries.get(key) || {}, why = cause === 'NOT_OPEN' ? t('not_open', { name: robot.not_open }) : outageWords(robot);
    return { name, robot: name, why, todo: `→ ${t(`todo_${cause}`)}` };
  }
  const mission = entries.get(key) || {};
  return { name: `${t('mission')} ${fullName(mission)}`, why: [mission.robot, reasonWords(mission, me)].filter(Boolean).join(': '), todo: '', mission, robot: mission.robot };
}

function alarmRow(alarm) {
  const row = make('li', { class: alarm.seen_by ? 'seen' : null }, make('p', {}, alarm.robot ? colourDot(alarm.robot) : '', make('b', {}, alarm.name), ' ', ...withCode(alarm.why), ' ', alarm.todo),
    make('p', { class: 'since' }, t('since', { time: momentOf(alarm.since) }), alarm.seen_by ? ` · ${t('seen_by', { person: alarm.seen_by })}` : ''),
    alarm.mission ? answerButtons(alarm.mission, me) : '');
  if (!alarm.seen_by && me.role !== 'see') row.append(make('button', { 'data-act': 'acknowledge', 'aria-label': `${t('act_acknowledge')}: ${alarm.name}`, onclick: () => act({ act: 'acknowledge', name: alarm.key }) }, t('act_acknowledge')));
  return row;
}

export function showFold() {
  $('alarm_list').hidden = isFolded();
  $('fold_alarms').setAttribute('aria-expanded', String(!isFolded()));
  $('sound').setAttribute('aria-pressed', String(hasSound()));
}

// A browser plays no sound before the user has pressed something on the page.
export const isSounding = () => unseen > 0 && hasSound() && Boolean(navigator.userActivation?.hasBeenActive);

function sound() {
  if (!isSounding()) return;
  audio = audio || new AudioContext();
  const tone = audio.createOscillator(), loudness = audio.createGain(), now = audio.currentTime;
  tone.frequency.value = 740;
  loudness.gain.setValueAtTime(0.15, now);
  loudness.gain.exponentialRampToValueAtTime(0.001, now + 0.4);
  tone.connect(loudness).connect(audio.destination);
  tone.start(now); tone.stop(now + 0.4);
}
