// Colours that people with any colour vision can tell apart; shape and text repeat what they say.

export const verdictColor = { landable: '#00689d', unverified: '#b35c00', rejected: '#6b6b6b' };

// Cividis, dark to bright, for 0..1.
const cividis = [
  [0, 32, 77], [32, 56, 109], [73, 83, 109], [109, 111, 113], [142, 139, 120], [178, 169, 112],
  [215, 200, 96], [255, 234, 70],
];

export function gradeColor(grade) {
  const place = Math.min(Math.max(grade, 0), 1) * (cividis.length - 1);
  const low = Math.min(Math.floor(place), cividis.length - 2);
  const share = place - low;
  const mixed = cividis[low].map((value, i) =>
    Math.round(value + (cividis[low + 1][i] - value) * share));
  return `rgb(${mixed.join(',')})`;
}
