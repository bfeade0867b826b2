// The texts of the page in one language. For a missing text, the page shows its key.
const LANGUAGES = ['en', 'de'];
let table = {}, patterns = [];
export let language = 'en';

const textsOf = async name => (await fetch(`/page/${name}.json`)).json();

export async function useLanguage(wanted) {
  const name = LANGUAGES.includes(wanted) ? wanted : 'en', english = textsOf('en');
  const [own, spoken] = await Promise.all([name === 'en' ? english : textsOf(name), english]);
  // The language's name and the texts change together, so a list that is shown meanwhile is marked with the right language.
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

// The English table contains the sentences of the fleet manager. The page recognises such a sentence by its text.
function patternsOf(english) {
  return Object.entries(english).filter(([key]) => /^(words|outage)_/.test(key)).map(([key, text]) => ({
    key, names: [...text.matchAll(/\{(\w+)\}/g)].map(found => found[1]),
    form: new RegExp(`^${text.replace(/[.*+?^$()|[\]\\]/g, '\\$&').replace(/\{why\}/g, '(.+)').replace(/\{\w+\}/g, '([^:]+?)')}$`, 's') }));
}

// For each sentence that ends with a command to type: the key of the text to show beside buttons for the same act.
const BESIDE_BUTTONS = { words_ask: 'step_asks', words_step_person: 'step_of_person', words_step_program: 'step_of_program' };

// Returns a text of the fleet manager in the language of the page. Texts that come from robots stay unchanged.
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

// Returns a moment as text: for a moment of today, only the time.
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
