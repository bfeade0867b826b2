// Functions that make elements from texts, never from HTML.
const SVG = 'http://www.w3.org/2000/svg';

export const $ = id => document.getElementById(id);

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'onclick') element.addEventListener('click', value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined && child !== ''));
  return element;
}

export function makeSvg(tag, attributes = {}) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

// Shows items as children of a list. Only changed items are made again, and the focus stays where it was.
export function showRows(list, items, keyOf, build, context = '') {
  const known = list.rows || (list.rows = new Map());
  const wanted = new Set();
  let place = list.firstElementChild;
  for (const item of items) {
    const key = String(keyOf(item)), text = context + JSON.stringify(item);
    wanted.add(key);
    let row = known.get(key);
    if (!row || row.text !== text) {
      const active = row && row.element.contains(document.activeElement) ? document.activeElement : null;
      const element = build(item);
      element.dataset.key = key;
      if (row) {
        if (row.element === place) place = element;
        row.element.replaceWith(element);
        if (active) (element.contains(active) ? active : element.querySelector(`[data-act="${active.dataset.act}"]`))?.focus();
      }
      row = { text, element };
      known.set(key, row);
    }
    if (row.element !== place) list.insertBefore(row.element, place);
    else place = place.nextElementSibling;
  }
  for (const [key, row] of known) {
    if (!wanted.has(key)) { row.element.remove(); known.delete(key); }
  }
}

export function showTable(table, head, rows) {
  for (const part of table.querySelectorAll('thead, tbody')) part.remove();
  table.append(
    make('thead', {}, make('tr', {}, ...head.map(cell => make('th', { scope: 'col' }, cell)))),
    make('tbody', {}, ...rows.map(row => make('tr', {}, ...row.map(cell => make('td', {}, String(cell)))))));
}
