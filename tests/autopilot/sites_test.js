// Every site of a service with many worlds becomes a mission that is read back equal.
//
//   FREELSD_SITES_URL=http://127.0.0.1:8080 node --test tests/autopilot/sites_test.js

import assert from 'node:assert/strict';
import test from 'node:test';

import { ardupilotItems, landingOfApproach } from '../../server/mavlink/landing_items.js';
import { areSame } from '../../server/mavlink/mission_items.js';
import { ServiceProblem } from '../../server/mavlink/service.js';
import { Service } from '../../server/mavlink/service.js';
import { Rig } from './mission_rig.js';
import { report } from './report.js';

const url = process.env.FREELSD_SITES_URL;
const skip = url ? false : 'set FREELSD_SITES_URL to a service with stored sites';

async function allSites() {
  const response = await fetch(new URL('v1/sites?limit=1000', `${url}/`));
  const { features } = await response.json();
  return features.map(({ properties, geometry }) => ({ ...properties, geometry }));
}

// What the link asks the service for, asked before: the stepped time does not wait.
async function answersFor(service, siteId) {
  const site = await service.site(siteId);
  try {
    return { site, approach: await service.approach(siteId) };
  } catch (error) {
    if (error instanceof ServiceProblem) return { site, error };
    throw error;
  }
}

function rigAt({ geometry }, answers) {
  const [longitude_deg, latitude_deg, altitude_m] = geometry.coordinates;
  const home = { latitude_deg: latitude_deg - 0.004, longitude_deg, altitude_m: Math.floor(altitude_m ?? 400) - 20 };
  return new Rig({ options: { home, rates_hz: { WIND: 0 } }, service: {
    site: async () => answers.site,
    approach: async () => {
      if (answers.error) throw answers.error;
      return answers.approach;
    },
  } });
}

test('every site of the service: its mission is read back equal, a rejected one is refused', { skip, timeout: 1_800_000 }, async () => {
  const service = new Service(url);
  const flights = new Set();
  const counts = { landable: 0, unverified: 0, rejected: 0 };
  for (const site of await allSites()) {
    const answers = await answersFor(service, site.id);
    const rig = rigAt(site, answers);
    await rig.step(3);
    rig.landings.take({ id: 'c1', kind: 'mission', site_id: site.id });
    await rig.step(12);
    flights.add(site.flight_id);
    ++counts[site.verdict];
    const { state, detail } = rig.told.get('c1');
    if (site.verdict === 'rejected') {
      assert.equal(state, 'failed', site.id);
      continue;
    }
    assert.equal(state, 'done', `${site.id}: ${detail}`);
    assert.deepEqual({ state: rig.mission.state, site: rig.mission.site }, { state: 'current', site: site.id });
    const ours = ardupilotItems(landingOfApproach(site.id, answers.approach), { parameters: rig.plane.parameters, home_altitude_m: rig.plane.home.altitude_m });
    const flown = rig.plane.mission.slice(-ours.length);
    // The autopilot's own altitude above home is measured with noise.
    assert.ok(areSame(flown.map((one) => ({ ...one, param1: 0 })), ours.map((one) => ({ ...one, param1: 0 }))), site.id);
    assert.ok(Math.abs(flown.at(-1).param1 - ours.at(-1).param1) <= 1, site.id);
  }
  const numSites = counts.landable + counts.unverified;
  report('missions', `sites of a service with ${flights.size} worlds`,
    `${numSites} of ${numSites} read back equal (${counts.landable} landable, ${counts.unverified} unverified); ${counts.rejected} of ${counts.rejected} rejected ones refused`);
});
