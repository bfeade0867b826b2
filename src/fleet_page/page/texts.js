// The texts of the page in one language; a text that is missing shows its key.
const LANGUAGES = ['en', 'de'];
let table = {};
export let language = 'en';

export async function useLanguage(wanted) {
  language = LANGUAGES.includes(wanted) ? wanted : 'en';
  table = await (await fetch(`/page/${language}.json`)).json();
  document.documentElement.lang = language;
  for (const element of document.querySelectorAll('[data-t]')) element.textContent = t(element.dataset.t);
  for (const element of document.querySelectorAll('[data-label]')) element.setAttribute('aria-label', t(element.dataset.label));
  document.title = t('title');
}

export function preferred() {
  return stored('language') || (navigator.language || 'en').slice(0, 2);
}

export function t(key, values = {}) {
  return (table[key] || key).replace(/\{(\w+)\}/g, (_, name) => String(values[name] ?? ''));
}

export function stored(name) {
  try { return localStorage.getItem(name); } catch (error) { return null; }
}

export function store(name, value) {
  try { localStorage.setItem(name, value); } catch (error) { /* a private window: only not remembered */ }
}

export function timeOf(seconds) {
  return new Date(seconds * 1000).toLocaleTimeString(language);
}

export function dateOf(seconds) {
  return new Date(seconds * 1000).toLocaleString(language);
}

export function duration(seconds) {
  const whole = Math.max(0, Math.round(seconds));
  return whole < 120 ? `${whole} s` : whole < 7200 ? `${Math.round(whole / 60)} min` : `${(whole / 3600).toFixed(1)} h`;
}
