// The list of flights in the header.

import { byId } from './dom.js';

const textsOf = (options) => [...options].map((option) => option.value + option.text).join();

// Returns the flight to show: the one that is shown, else the one in the address, else the first; null without flights.
export function chosenFlight(flights, shown) {
  if (flights.some(({ id }) => id === shown)) return shown;
  const wanted = new URLSearchParams(location.hash.slice(1)).get('flight');
  return (flights.find(({ id }) => id === wanted) ?? flights[0])?.id ?? null;
}

export function drawFlightChoice(flights, chosen) {
  const select = byId('flight');
  const options = flights.length ? flights.map(({ id, name }) => new Option(name || id, id)) : [new Option('none', '')];
  if (textsOf(select.options) !== textsOf(options)) select.replaceChildren(...options);
  select.value = chosen ?? '';
  for (const node of document.querySelectorAll('[data-needs-flight]')) node.hidden = !chosen;
  byId('no-flight').hidden = Boolean(chosen);
}
