#!/usr/bin/env node
// Flies the trial of guidance after an engine failure over a mosaic of seeded worlds.
//
//   trial.js --url URL --ground PATH --out FILE [--flights N] [--seed N]
//
// PATH is the surface that freelsd-judge-tracks --heights wrote. FILE becomes the input of
// freelsd-judge-tracks --tracks. See trial.sh.

import { writeFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { Service } from '../../../server/mavlink/service.js';
import { FlownTrial } from './flown_trial.js';
import { surveysOf } from './surveys.js';
import { TrueGround } from './true_ground.js';

const { values } = parseArgs({ options: {
  url: { type: 'string' }, ground: { type: 'string' }, out: { type: 'string' },
  flights: { type: 'string', default: '10' }, seed: { type: 'string', default: '1' },
  altimeter: { type: 'string', default: 'survey' },
} });

const ground = new TrueGround(values.ground);
const service = new Service(values.url);
const sites = await (await fetch(new URL('v1/emergency/export?f=geojson', values.url))).json();
const surveys = surveysOf(sites, ground);
const tracks = [];
let numWithout = 0;
for (let seed = Number(values.seed); tracks.length < Number(values.flights); ++seed) {
  const flight = await new FlownTrial({ ground, service, surveys, seed, altimeter: values.altimeter }).fly();
  if (!flight) {
    ++numWithout;
    continue;
  }
  tracks.push(flight);
  console.error(`flight ${flight.id}: ${flight.sites.join(', ')}`);
  writeFileSync(values.out, JSON.stringify({ tracks, num_without_site: numWithout }));
}
