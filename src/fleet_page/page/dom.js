// Functions that make elements from texts, never from HTML.
const SVG = 'http://www.w3.org/2000/svg';

export const $ = id => document.getElementById(id);

// On a narrow screen (the same width as in page.css) the map is above the panel.
export const narrow = matchMedia('(max-width: 1000px)');

export function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'onclick') element.addEventListener('click', value);
    else if (value !== null && value !== undefined && value !== false) element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.filter(child => child !== null && child !== undefined && child !== ''));
  return element;
}

// Makes a text in which a command to type is between backquotes.
export function withCode(text) {
  return text.split('`').map((part, k) => k % 2 ? make('code', {}, part) : part);
}

export function makeSvg(tag, attributes = {}) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  return element;
}

// Opens a menu beside a button. The page has only one menu, so changes of a row or of the map do not close it.
export function openMenu(button, items) {
  const menu = $('menu'), row = button.closest('[data-key]'), list = row.parentElement.id;
  const back = () => {
    const again = [...$(list).children].find(one => one.dataset.key === row.dataset.key);
    (again?.querySelector('[data-act=menu]') || again)?.focus();
  };
  const close = () => { menu.hidden = true; menu.replaceChildren(); document.removeEventListener('pointerdown', outside); removeEventListener('resize', close); removeEventListener('scroll', close, true); };
  const outside = event => { if (!menu.contains(event.target)) close(); };
  close();
  menu.setAttribute('aria-label', button.getAttribute('aria-label'));
  menu.append(...items.map(([act, text, run]) => make('button', { role: 'menuitem', tabindex: -1, 'data-act': act, onclick: () => { close(); back(); run(); } }, text)));
  menu.hidden = false;
  const at = button.getBoundingClientRect(), size = menu.getBoundingClientRect();
  menu.style.left = `${Math.max(4, at.right - size.width)}px`;
  menu.style.top = `${at.bottom + size.height > innerHeight ? Math.max(4, at.top - size.height) : at.bottom}px`;
  menu.onkeydown = event => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key], buttons = [...menu.children];
    if (step) { event.preventDefault(); buttons[(buttons.indexOf(document.activeElement) + step + buttons.length) % buttons.length].focus(); }
    if (event.key === 'Escape' || event.key === 'Tab') { event.preventDefault(); close(); back(); }
  };
  menu.firstElementChild.focus();
  document.addEventListener('pointerdown', outside);
  addEventListener('resize', close);
  addEventListener('scroll', close, true);
}

// Shows items as children of a list. Only changed items are made anew, and the focus does not move.
export function showRows(list, items, keyOf, build, context = '') {
  const known = list.shownRows || (list.shownRows = new Map());
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
