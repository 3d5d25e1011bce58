'use strict';
// Collects the faults of the boxes of a page: marks larger than their cells, texts that overlap or are cut.

const faults = [];
const note = (what, part) => { if (faults.length < 20) faults.push(what + ': ' + (part.textContent || part.className.baseVal || part.className).trim().replace(/\s+/g, ' ').slice(0, 40)); };
const box = (part) => part.getBoundingClientRect();
const shown = (part) => { const { width, height } = box(part); return width > 0 && height > 0 && part.checkVisibility({ visibilityProperty: true }); };
const inside = (a, b) => a.left >= b.left - 0.6 && a.right <= b.right + 0.6 && a.top >= b.top - 0.6 && a.bottom <= b.bottom + 0.6;
for (const cell of document.querySelectorAll('.cell')) {
  const own = box(cell.querySelector('rect'));
  for (const part of cell.querySelectorAll('text, tspan, path, circle')) if (shown(part) && !inside(box(part), own)) note('larger than its cell', part);
}
for (const figure of document.querySelectorAll('figure.map')) {
  const own = box(figure.querySelector('.drawing > svg'));
  const cell = box(figure.querySelector('.cell rect'));
  for (const part of figure.querySelectorAll('.drawing > svg :is(text, path, circle, rect)')) {
    if (shown(part) && (box(part).width > cell.width + 0.6 || box(part).height > cell.height + 0.6)) note('larger than a cell', part);
  }
  for (const part of figure.querySelectorAll('.piece, .token, .chosen')) if (shown(part) && !inside(box(part), own)) note('outside of its map', part);
}
// The ink of a text is lower than its box.
const texts = [];
const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
for (let node = walker.nextNode(); node; node = walker.nextNode()) {
  const part = node.parentElement;
  if (!node.data.trim() || part.closest('script, style, title, option, select, .slanted') || !shown(part)) continue;
  const range = document.createRange();
  range.selectNodeContents(node);
  for (const { left, right, top, bottom } of range.getClientRects()) {
    const high = bottom - top;
    if (right - left > 1) texts.push({ part, left: left + 0.5, right: right - 0.5, top: top + 0.17 * high, bottom: bottom - 0.2 * high });
  }
}
texts.sort((a, b) => a.top - b.top);
texts.forEach((a, i) => {
  for (let j = i + 1; j < texts.length && texts[j].top < a.bottom; j += 1) {
    const b = texts[j];
    if (a.part !== b.part && a.left < b.right && b.left < a.right) note('overlaps ' + b.part.textContent.trim().slice(0, 12), a.part);
  }
  const frame = a.part.closest('.scroll') ? null : a.part.closest('svg');
  if (a.part.closest('.scroll')) return;
  if (a.left < 0 || a.right > innerWidth) note('wider than the page', a.part);
  if (frame && !inside(a, box(frame))) note('cut by its drawing', a.part);
});
for (const part of document.querySelectorAll('body *')) {
  const { overflowX } = getComputedStyle(part);
  if (['hidden', 'clip'].includes(overflowX) && part.localName !== 'svg' && part.scrollWidth > part.clientWidth + 1) note('cut', part);
}
if (document.documentElement.scrollWidth > innerWidth) note('the page is too wide', document.querySelector('h1'));
parent.document.body.dataset[window.name] = faults.length ? faults.join(' | ') : 'none';
