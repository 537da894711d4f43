// The true surface of a mosaic of seeded worlds, as freelsd-judge-tracks writes it.

import { readFileSync } from 'node:fs';

export class TrueGround {
  #header;
  #altitudes_m;

  constructor(path) {
    this.#header = JSON.parse(readFileSync(`${path}.json`, 'utf8'));
    const bytes = readFileSync(`${path}.f32`);
    this.#altitudes_m = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.length / 4);
  }

  get lowest_m() { return this.#header.lowest_ground_m; }

  // A part of the whole, 0 to 1 from the west and from the south.
  placeAt(eastShare, northShare) {
    const { latitude_deg, longitude_deg, latitude_step_deg, longitude_step_deg, num_rows, num_cols } = this.#header;
    return {
      latitude_deg: latitude_deg + northShare * (num_rows - 1) * latitude_step_deg,
      longitude_deg: longitude_deg + eastShare * (num_cols - 1) * longitude_step_deg,
    };
  }

  // Of the nearest cell; outside, of the nearest edge.
  altitude_m({ latitude_deg, longitude_deg }) {
    const header = this.#header;
    const row = Math.round((latitude_deg - header.latitude_deg) / header.latitude_step_deg);
    const col = Math.round((longitude_deg - header.longitude_deg) / header.longitude_step_deg);
    const inside = (index, count) => Math.min(count - 1, Math.max(0, index));
    return this.#altitudes_m[inside(row, header.num_rows) * header.num_cols + inside(col, header.num_cols)];
  }
}
