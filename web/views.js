// The views of the side panel: one of them is visible.

import { byId } from './dom.js';

const tabs = ['sites', 'flight', 'upload'];
// The tab of a view without its own.
const tabOf = (name) => (tabs.includes(name) ? name : name === 'next-look' ? 'flight' : 'sites');

export const isVisible = (name) => !document.querySelector(`[data-view="${name}"]`).hidden;

export function showView(name) {
  for (const view of document.querySelectorAll('[data-view]')) view.hidden = view.dataset.view !== name;
  const tab = tabOf(name);
  for (const button of document.querySelectorAll('[data-tab]')) {
    button.setAttribute('aria-selected', String(button.dataset.tab === tab));
  }
  byId('panel').scrollTop = 0;
  dispatchEvent(new CustomEvent('freelsd-view', { detail: name }));
}

// on: {changed(): a tab was chosen, back(): the user wants the list of sites, escape(): returns whether it closed something}
export function connectViews(on) {
  for (const tab of document.querySelectorAll('[data-tab]')) {
    tab.addEventListener('click', () => { showView(tab.dataset.tab); on.changed(); });
  }
  const back = (view) => {
    if (tabOf(view) === 'sites') return on.back();
    showView(tabOf(view));
    return byId(`open-${view}`).focus({ preventScroll: true });
  };
  for (const button of document.querySelectorAll('[data-back]')) {
    button.addEventListener('click', () => back(button.closest('[data-view]').dataset.view));
  }
  // The browser closes an open dialog on Escape.
  addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || document.querySelector('dialog[open]') || on.escape()) return;
    const shown = document.querySelector('[data-view]:not([hidden])').dataset.view;
    if (!tabs.includes(shown)) back(shown);
  });
}
