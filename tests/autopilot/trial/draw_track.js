#!/usr/bin/env node
// Draws one flight of the trial over what stands on the ground: told ways yellow, track white and red
// from the final on, told disc green, place of contact red.
//
//   draw_track.js --tracks FILE --ground PATH --id ID --out FILE.png [--around METRES]

import { readFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { FlatFrame } from '../../../server/mavlink/flat_frame.js';
import { Picture } from './picture.js';
import { TrueGround } from './true_ground.js';

const { values } = parseArgs({ options: {
  tracks: { type: 'string' }, ground: { type: 'string' }, id: { type: 'string' }, out: { type: 'string' },
  around: { type: 'string', default: '200' },
} });
const flight = JSON.parse(readFileSync(values.tracks, 'utf8')).tracks.find(({ id }) => id === values.id);
const ground = new TrueGround(values.ground);
const around_m = Number(values.around);
const perMetre = 2;
const size = 2 * around_m * perMetre;
const frame = new FlatFrame(flight.touchdown);
const picture = new Picture(size, size);

const pixel = ({ latitude_deg, longitude_deg }) => {
  const { east_m, north_m } = frame.toLocal({ latitude_deg, longitude_deg });
  return [(east_m + around_m) * perMetre, (around_m - north_m) * perMetre];
};
const heightAt = (column, row) => ground.altitude_m(frame.toGlobal({ east_m: column / perMetre - around_m, north_m: around_m - row / perMetre }));

// What is higher than the ground within some metres stands there.
function drawGround() {
  const reach = 8 * perMetre;
  for (let row = 0; row < size; ++row) {
    for (let column = 0; column < size; ++column) {
      const here_m = heightAt(column, row);
      const low_m = Math.min(here_m, ...[[-1, 0], [1, 0], [0, -1], [0, 1]].map(([x, y]) => heightAt(column + x * reach, row + y * reach)));
      const stands = Math.min(1, Math.max(0, here_m - low_m - 1) / 6);
      const slope = Math.max(-30, Math.min(30, (here_m - heightAt(column + 2, row + 2)) * 30));
      picture.set(column, row, [60 + slope, 80 + slope - 40 * stands, 60 + slope + 150 * stands]);
    }
  }
}

function drawLines() {
  for (const { path } of flight.paths) {
    path.slice(1).forEach(([longitude_deg, latitude_deg], i) => picture.line(
      pixel({ longitude_deg: path[i][0], latitude_deg: path[i][1] }), pixel({ longitude_deg, latitude_deg }), [150, 140, 40]));
  }
  flight.points.slice(1).forEach(([time_s, latitude_deg, longitude_deg], i) => picture.line(
    pixel({ latitude_deg: flight.points[i][1], longitude_deg: flight.points[i][2] }), pixel({ latitude_deg, longitude_deg }),
    flight.final && time_s > flight.final.time_s ? [255, 80, 80] : [255, 255, 255]));
  picture.circle(pixel(flight.touchdown), flight.touchdown_uncertainty_m * perMetre, [60, 255, 60]);
  if (flight.contact) picture.circle(pixel(flight.contact), 2 * perMetre, [255, 0, 0]);
}

drawGround();
drawLines();
picture.write(values.out);
