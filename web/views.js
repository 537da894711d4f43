// The views of the side panel: one of them is visible.

import { byId } from './dom.js';

// Views without a tab of their own belong to the tab `sites`.
const tabs = ['sites', 'flight', 'upload'];

export const isVisible = (name) => !document.querySelector(`[data-view="${name}"]`).hidden;

export function showView(name) {
  for (const view of document.querySelectorAll('[data-view]')) view.hidden = view.dataset.view !== name;
  const tab = tabs.includes(name) ? name : 'sites';
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
  for (const back of document.querySelectorAll('[data-back]')) back.addEventListener('click', on.back);
  // The browser closes an open dialog on Escape.
  addEventListener('keydown', (event) => {
    if (event.key !== 'Escape' || document.querySelector('dialog[open]') || on.escape()) return;
    if (!document.querySelector('[data-tab="sites"][aria-selected="true"]') || isVisible('sites')) return;
    on.back();
  });
}
