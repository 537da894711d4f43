// Elevation above mean sea level over east, north of home.

import { readFileSync } from 'node:fs';

import { clamp } from './frame.js';

export const flat = (altitude_m) => () => altitude_m;

// A file of JSON: { west_m, south_m, cell_m, num_columns, num_rows, elevations_m }; the first row is
// the southern one. Bilinear between the centres of cells; outside, the nearest cell.
export function gridFrom(path) {
  const grid = JSON.parse(readFileSync(path, 'utf8'));
  const { west_m, south_m, cell_m, num_columns, num_rows, elevations_m } = grid;
  if (elevations_m?.length !== num_columns * num_rows) {
    throw new Error(`${path}: ${elevations_m?.length} elevations, expected ${num_columns} x ${num_rows}`);
  }
  const at = (column, row) => elevations_m[row * num_columns + column];
  return (east_m, north_m) => {
    const x = clamp((east_m - west_m) / cell_m - 0.5, 0, num_columns - 1);
    const y = clamp((north_m - south_m) / cell_m - 0.5, 0, num_rows - 1);
    const column = Math.min(Math.floor(x), num_columns - 2);
    const row = Math.min(Math.floor(y), num_rows - 2);
    const right = x - column;
    const up = y - row;
    return (1 - up) * ((1 - right) * at(column, row) + right * at(column + 1, row)) +
      up * ((1 - right) * at(column, row + 1) + right * at(column + 1, row + 1));
  };
}
