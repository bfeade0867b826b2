"""Finds texts of the page that are cut off, that lie on each other, or that lie outside the window.

Only the visible part of an area that scrolls counts. Labels of robots may cover names on the map.
"""
from __future__ import annotations

from typing import Any, List

FAULTS = r'''
const OVERLAYS = ['#said', '#menu', '#layers', '#bars', '#past', '.skip', '#zoom', 'header'];
const PLAY = 1.5, LEAST = 3, HIDDEN = 500; // px
const root = element => element.closest(OVERLAYS.join(',')) || document.body;
const tell = (kind, text, element) => `${kind}: "${text.trim().slice(0, 50)}" in ${
    [element.tagName.toLowerCase(), element.id && `#${element.id}`,
     element.closest('[data-key]')?.dataset.key].filter(Boolean).join(' ')}`;
const within = (box, other) => ({
    left: Math.max(box.left, other.left), right: Math.min(box.right, other.right),
    top: Math.max(box.top, other.top), bottom: Math.min(box.bottom, other.bottom) });
const isThere = box => box.right - box.left > LEAST && box.bottom - box.top > LEAST;
const found = new Set(), texts = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
while (walker.nextNode()) {
    const node = walker.currentNode, own = node.parentElement;
    if (!node.data.trim() || own.closest('option, datalist, canvas, title, script')) continue;
    if (!own.checkVisibility({ visibilityProperty: true }) || own.closest('.skip')) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    for (const whole of range.getClientRects()) {
        // a line of text is higher than its letters
        const high = whole.bottom - whole.top;
        if (whole.right < -HIDDEN) continue;  // only for screen readers
        let box = { left: whole.left, right: whole.right, top: whole.top + 0.2 * high,
                    bottom: whole.bottom - 0.2 * high }, scrolls = false;
        for (let outer = own; outer && outer !== document.body; outer = outer.parentElement) {
            const style = getComputedStyle(outer), edge = outer.getBoundingClientRect();
            const isButton = outer.tagName === 'BUTTON';
            if (style.overflowX === 'visible' && !isButton) continue;
            const isScroller = [style.overflowX, style.overflowY].some(
                value => value === 'auto' || value === 'scroll');
            if (!isScroller && !scrolls && !outer.closest('svg') && (
                    box.left < edge.left - PLAY || box.right > edge.right + PLAY ||
                    box.top < edge.top - PLAY || box.bottom > edge.bottom + PLAY))
                found.add(tell('cut', node.data, outer));
            scrolls = scrolls || isScroller;
            box = within(box, edge);
        }
        if (!scrolls && (box.left < -PLAY || box.right > innerWidth + PLAY))
            found.add(tell('outside', node.data, own));
        box = within(box, { left: 0, top: 0, right: innerWidth, bottom: innerHeight });
        if (isThere(box)) texts.push({ box, own, text: node.data, root: root(own) });
    }
}
for (const select of document.querySelectorAll('select')) {
    if (!select.checkVisibility() || !select.selectedOptions.length) continue;
    const paint = document.createElement('canvas').getContext('2d');
    const style = getComputedStyle(select);
    paint.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
    const text = select.selectedOptions[0].textContent, room = select.clientWidth
        - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight) - 18; // the arrow
    if (paint.measureText(text).width > room + PLAY) found.add(tell('cut', text, select));
}
const isLabel = one => Boolean(one.own.closest('.robot'));
texts.forEach((one, k) => texts.slice(k + 1).forEach(other => {
    if (one.own === other.own || one.root !== other.root || isLabel(one) !== isLabel(other)) return;
    if (isThere(within(one.box, other.box)))
        found.add(`${tell('overlap', one.text, one.own)} and ${tell('', other.text, other.own)}`);
}));
return [...found];'''


def layout_faults(window: Any) -> List[str]:
    """Returns the faults of the present content of the window."""
    faults: List[str] = window.script(FAULTS)
    return faults
