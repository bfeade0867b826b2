// The connection to the server: its events fill `entries`, and acts are sent to it.
export const entries = new Map();
export let site = { vertices: [], edges: [], radii: {}, map: null };
export let heardAt = 0;

let source = null;
const asking = new Set(); // requests without an answer yet

export async function get(path) {
  const request = new AbortController();
  asking.add(request);
  try {
    const answer = await fetch(path, { signal: request.signal });
    if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).text || String(answer.status));
    return await answer.json();
  } finally {
    asking.delete(request);
  }
}

// A browser has six connections to a server. A stop must not wait for requests that the server does not answer.
export function makeWay() {
  for (const request of asking) request.abort();
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
// `wanted` is the part of the address that says which layers are sent.
export function follow(wanted, changed, refused) {
  if (source) source.close();
  source = new EventSource(`/api/events?${wanted()}`);
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
    else setTimeout(() => follow(wanted, changed, refused), 2000);
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
