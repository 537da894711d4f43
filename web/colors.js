// Colours for any colour vision. Signs and text repeat their meaning.

// The same values as in the server's pictures of the layers `hazard`, `distance` and `risk`.
export const safetyColor = { free: '#7ed396', hazard: '#c84600', unseen: '#1a1a1a' };
// Layers in which unseen cells have a colour.
export const marksUnseen = (name) => ['hazard', 'distance', 'risk'].includes(name);

// Cividis colour map, dark to bright, for 0 to 1.
const cividis = [
  [0, 34, 78], [59, 73, 108], [112, 113, 115], [165, 156, 116], [225, 204, 85], [254, 232, 56],
];

export function gradeColor(grade) {
  const place = Math.min(Math.max(grade, 0), 1) * (cividis.length - 1);
  const low = Math.min(Math.floor(place), cividis.length - 2);
  const share = place - low;
  const mixed = cividis[low].map((value, i) =>
    Math.round(value + (cividis[low + 1][i] - value) * share));
  return `rgb(${mixed.join(',')})`;
}
