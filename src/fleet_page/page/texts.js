// The texts of the page in one language; a text that is missing shows its key.
const LANGUAGES = ['en', 'de'];
let table = {}, patterns = [];
export let language = 'en';

const textsOf = async name => (await fetch(`/page/${name}.json`)).json();

export async function useLanguage(wanted) {
  const name = LANGUAGES.includes(wanted) ? wanted : 'en', english = textsOf('en');
  const [own, spoken] = await Promise.all([name === 'en' ? english : textsOf(name), english]);
  // The name changes together with the texts: a list that is shown meanwhile is in the language that it says.
  language = name; table = own; patterns = patternsOf(spoken);
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll('[data-t]')) element.textContent = t(element.dataset.t);
  for (const element of document.querySelectorAll('[data-label]')) element.setAttribute('aria-label', t(element.dataset.label));
}

export function preferred() {
  return stored('language') || (navigator.language || 'en').slice(0, 2);
}

export function t(key, values = {}) {
  return (table[key] || key).replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ''));
}

// The English table has the fleet manager's sentences: they are recognised by the texts of these keys.
function patternsOf(english) {
  return Object.entries(english).filter(([key]) => /^(words|outage)_/.test(key)).map(([key, text]) => ({
    key, names: [...text.matchAll(/\{(\w+)\}/g)].map(found => found[1]),
    form: new RegExp(`^${text.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace(/\{why\}/g, '(.+)').replace(/\{\w+\}/g, '([^:]+?)')}$`, 's') }));
}

// Sentences that end with a command to type, and their texts beside the buttons that do the same.
const BESIDE_BUTTONS = { words_ask: 'step_asks', words_step_person: 'step_of_person', words_step_program: 'step_of_program' };

// A text of the fleet manager in the language of the page; texts that come from robots stay as they are.
export function said(words, isBesideButtons = false) {
  for (const { key, names, form } of patterns) {
    const found = form.exec(words);
    if (found) return t((isBesideButtons && BESIDE_BUTTONS[key]) || key, Object.fromEntries(names.map((name, k) => [name, name === 'why' ? said(found[k + 1]) : found[k + 1]])));
  }
  const [, subject, rest] = /^([^\s:]+): (.+)$/s.exec(words) || [];
  return subject ? `${subject}: ${said(rest)}` : words;
}

export function stored(name) {
  try { return localStorage.getItem(name); } catch (error) { return null; }
}

export function store(name, value) {
  try { localStorage.setItem(name, value); } catch (error) { /* in a private window nothing is stored */ }
}

export function timeOf(seconds) {
  return new Date(seconds * 1000).toLocaleTimeString(language);
}

export function clockOf(seconds) {
  const isToday = new Date(seconds * 1000).toDateString() === new Date().toDateString();
  return isToday ? new Date(seconds * 1000).toLocaleTimeString(language, { hour: '2-digit', minute: '2-digit' }) : dateOf(seconds);
}

// The time alone for a moment of today.
export function momentOf(seconds) {
  return new Date(seconds * 1000).toDateString() === new Date().toDateString() ? timeOf(seconds) : dateOf(seconds);
}

export function dateOf(seconds) {
  return new Date(seconds * 1000).toLocaleString(language);
}

export function duration(seconds) {
  const whole = Math.max(0, Math.round(seconds));
  return whole < 120 ? `${whole} s` : whole < 7200 ? `${Math.round(whole / 60)} min` : `${(whole / 3600).toFixed(1)} h`;
}
