// DOM helpers. They set text as text, never as HTML.

export const byId = (id) => document.getElementById(id);

// el('button', {class: 'chip', onclick: f, 'aria-label': 'x'}, 'text', node, null)
export function el(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
    else if (key === 'style') Object.entries(value).forEach(([k, v]) => node.style.setProperty(k, v));
    else node.setAttribute(key, value === true ? '' : String(value));
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
}

// svg('path', {d: '…'}): el for SVG nodes.
export function svg(name, attributes = {}, ...children) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, String(value));
  node.append(...children.flat());
  return node;
}

// Shows a short notice for 4 s. Screen readers announce it.
let noticeTimer = 0;
export function notify(text) {
  const notice = byId('notice');
  notice.textContent = text;
  notice.hidden = false;
  clearTimeout(noticeTimer);
  noticeTimer = setTimeout(() => { notice.hidden = true; }, 4000);
}

// The text of markup that somebody else wrote, such as the credit of a map file.
const entities = { amp: '&', lt: '<', gt: '>', quot: '"', apos: "'", nbsp: ' ', copy: '©' };
export const plainText = (markup) => markup.replace(/<[^>]*>/g, '')
  .replace(/&(?:#(\d{1,6})|(\w+));/g, (all, code, name) => (code ? String.fromCodePoint(code) : entities[name] ?? all))
  .replace(/\s+/g, ' ').trim();

// A colour of the style sheet, for canvases.
export const cssColor = (name) =>
  getComputedStyle(document.documentElement).getPropertyValue(name).trim();
