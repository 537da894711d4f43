// Finds what contradicts itself on the emergency view: sentences that exclude each other, numbers and colours that say
// something else than the words beside them, names of JSON keys.

const excluding = [
  ['in reach, and not', /in reach, best first/i, /no site (is )?in reach/i],
  ['in reach, and not', /in reach, best first/i, /✕ not in reach/],
  ['stored nearby, and not', /no (usable |stored )?site is stored/i, /\d+ (other )?stored sites? nearby/i],
  ['too low, and too high', /of height (is|are) missing/i, /surplus height|too high/i],
  ['wind unknown, and known', /wind (is )?unknown|wind not known|no wind is given/i, /wind of the same flight|wind as entered|wind \d+ \w+ old/i],
  ['no height of the ground, and a height', /no height of the ground is known/i, /ground at [−-]?\d/i],
  ['heading unknown, and known', /heading unknown|no heading is given/i, /heading from its track/i],
  ['position as entered, and of a flight', /position as entered/i, /position and altitude of flight/i],
  ['unchecked, and checked', /unchecked/i, /arrival margin|not in reach/i],
];
// Within one card.
const excludingOnCard = [
  ['landable, and not verified', /✓ landable/, /unverified/i],
  ['landable, and not in reach', /✓ landable/, /not in reach|missing|too high/i],
  ['dated, and undated', /date unknown/, /\d+ \w+ ago/],
  ['unverified without a reason', /\? unverified/, /^(?!.*Unverified: ).*$/s],
  ['not in reach without a reason', /✕ not in reach/, /^(?!.*(missing|too high|terrain)).*$/s],
];

const both = (text, pairs) => pairs.filter(([, a, b]) => a.test(text) && b.test(text)).map(([name]) => name);

export const jsonKeys = (text) => text.match(/(?<![\w./-])[a-z]+(?:_[a-z0-9]+)+\b/g) ?? [];

export const contradictions = (text) => [...both(text, excluding), ...jsonKeys(text).map((key) => `the JSON key ${key}`)];

const number = (text) => Number(text.replace('−', '-').replace(/[^\d.+-]/g, ''));

// What a colour may say of a margin, by its text.
function kindsFor(text) {
  if (/too high/i.test(text)) return ['high'];
  if (number(text) < 0) return ['short'];
  return [number(text) < 15 ? 'scarce' : 'enough'];
}

function marginFaults({ text, kind, hue }, where) {
  const [expected] = kindsFor(text);
  const hues = { enough: 'green', scarce: 'amber', short: 'red', high: 'red' };
  return [
    kind === expected ? null : `${where}: ${text} is shown as ${kind}`,
    hue === hues[expected] ? null : `${where}: ${text} is ${hue}`,
  ].filter(Boolean);
}

// Runs in the page.
function readView() {
  const text = (node) => node?.innerText.replace(/\s+/g, ' ').trim() ?? '';
  const hueOf = (node) => {
    const [r, g, b] = getComputedStyle(node).color.match(/\d+/g).map(Number);
    if (g > r && g > b) return 'green';
    return r > 2 * b && g > 0.4 * r ? 'amber' : r > g ? 'red' : 'other';
  };
  const kindOf = (node) => ['enough', 'scarce', 'short', 'high'].find((kind) => node.classList.contains(kind)) ?? 'none';
  const margins = (nodes) => [...nodes].map((node) => ({
    text: text(node), kind: kindOf(node), hue: hueOf(node.querySelector('strong') ?? node) }));
  const dialog = document.getElementById('emergency');
  const labels = [...dialog.querySelectorAll('.arrival span')];
  return {
    all: text(dialog),
    message: text(document.getElementById('em-message')),
    cards: [...dialog.querySelectorAll('.em-card')].map(text),
    onCards: margins(dialog.querySelectorAll('.em-arrival')),
    onMap: margins(labels.filter((label) => !label.hidden)),
    drawn: [...new Set(labels.map(kindOf))].sort(),
    legend: [...dialog.querySelectorAll('.key-arrival')].map(kindOf).sort(),
    legendText: text(document.getElementById('em-key')),
    outside: [...dialog.querySelectorAll('.em-card *')]
      .filter((node) => node.getBoundingClientRect().right > node.closest('.em-card').getBoundingClientRect().right + 1).map(text),
    tooWide_px: dialog.scrollWidth - dialog.clientWidth,
  };
}

// {view, faults}: what is shown, and a sentence for each thing that is wrong with it.
export async function readAloud(page) {
  const view = await page.evaluate(readView);
  const faults = [
    ...contradictions(view.all),
    ...view.cards.flatMap((card) => both(card, excludingOnCard)),
    ...view.onCards.flatMap((margin) => marginFaults(margin, 'card')),
    ...view.onMap.flatMap((margin) => marginFaults(margin, 'map')),
  ];
  if (/^(?:For .*: )?no site in reach/i.test(view.message) && view.cards.some((card) => card.includes('✓'))) {
    faults.push('no site in reach, above a site with a tick');
  }
  if (/[+−]\d/.test(view.legendText)) faults.push(`the legend states a number of no site: ${view.legendText}`);
  if (view.legend.join() !== view.drawn.join()) faults.push(`the legend has ${view.legend}, the map ${view.drawn}`);
  if (view.outside.length > 0) faults.push(`beyond its card: ${view.outside}`);
  if (view.tooWide_px > 0) faults.push(`${view.tooWide_px} px too wide`);
  return { view, faults };
}
