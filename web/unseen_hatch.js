// Unseen cells as a hatch: their black, translucent over a photograph, would look like dark ground.

import { safetyColor } from './colors.js';

const [red, green, blue] = safetyColor.unseen.match(/[0-9a-f]{2}/g).map((part) => parseInt(part, 16));

function contextOf({ width, height }) {
  const canvas = document.createElement('canvas');
  Object.assign(canvas, { width, height });
  return canvas.getContext('2d', { willReadFrequently: true });
}

// Clears the unseen pixels. data: RGBA, as of ImageData. Returns whether there are any, and whether pixels had no colour before.
export function clearUnseen(data) {
  let hasUnseen = false;
  let hasBlank = false;
  for (let i = 0; i < data.length; i += 4) {
    if (data[i + 3] === 0) hasBlank = true;
    else if (data[i] === red && data[i + 1] === green && data[i + 2] === blue) {
      hasUnseen = true;
      data[i + 3] = 0;
    }
  }
  return { hasUnseen, hasBlank };
}

// {picture: Blob without the unseen pixels, hasUnseen, mask: URL of what the hatch may cover, or null for all}
export async function withoutUnseen(blob) {
  const bitmap = await createImageBitmap(blob);
  const context = contextOf(bitmap);
  context.drawImage(bitmap, 0, 0);
  const pixels = context.getImageData(0, 0, bitmap.width, bitmap.height);
  bitmap.close();
  const { hasUnseen, hasBlank } = clearUnseen(pixels.data);
  if (!hasUnseen) return { picture: blob, hasUnseen, mask: null };
  const mask = hasBlank ? context.canvas.toDataURL() : null;
  context.putImageData(pixels, 0, 0);
  return { picture: await new Promise((resolve) => context.canvas.toBlob(resolve)), hasUnseen, mask };
}
