// The stored sites of all flights, also of deleted ones: what the page shows while there is no flight.

import { getAllSites } from './api.js';

const kLook_ms = 15000;
const kNumSites = 500;

// onSites(collection, isFirst): the sites were read. look() reads them at most every 15 s.
export function createStoredSites(onSites) {
  let asked_ms = null;
  return {
    async look() {
      const isFirst = asked_ms === null;
      if (!isFirst && performance.now() - asked_ms < kLook_ms) return;
      const sites = await getAllSites(kNumSites);
      asked_ms = performance.now();
      await onSites(sites, isFirst);
    },
  };
}
