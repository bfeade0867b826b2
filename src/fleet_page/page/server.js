// The connection to the server: its events fill `entries`, and acts are sent to it.
export const entries = new Map();
export let site = { vertices: [], edges: [], radii: {}, map: null };
export let heardAt = 0;

let source = null;

export async function get(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).text || String(answer.status));
  return answer.json();
}

export async function post(path, values) {
  try {
    const answer = await fetch(path, {
      method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(values) });
    return { status: answer.status, ...await answer.json() };
  } catch (error) {
    return { status: 0, ok: false, text: String(error.message || error) };
  }
}

// Calls changed(keys) after each message, and refused() if a login is needed.
export function follow(changed, refused) {
  if (source) source.close();
  source = new EventSource('/api/events');
  source.onmessage = event => {
    const update = JSON.parse(event.data);
    heardAt = Date.now();
    if (update.full) entries.clear();
    for (const key of update.gone) entries.delete(key);
    for (const [key, value] of Object.entries(update.set)) entries.set(key, value);
    changed(update.full ? null : new Set([...Object.keys(update.set), ...update.gone]));
  };
  source.onerror = async () => {
    if (source.readyState !== EventSource.CLOSED) return; // the browser connects again by itself
    const me = await get('/api/me').catch(() => null);
    if (me && !me.role) refused();
    else setTimeout(() => follow(changed, refused), 2000);
  };
}

export function unfollow() {
  if (source) source.close();
  source = null;
}

export async function loadSite() {
  site = await get('/api/site');
}

export function all(prefix) {
  const found = [];
  for (const [key, value] of entries) if (key.startsWith(prefix)) found.push([key.slice(prefix.length), value]);
  return found;
}
