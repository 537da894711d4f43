// From a landing that the service planned to the items that an autopilot flies.

import { nearTo } from '../antimeridian.js';
import { metresPerDegree } from '../flat_frame.js';
import { MavCmd, MavFrame } from '../messages.js';
import { item } from './mission_items.js';

const radians = (degrees) => (degrees * Math.PI) / 180;

export class NoLanding extends Error {}

const flareParameters = ['LAND_FLARE_SEC', 'LAND_FLARE_ALT', 'LAND_FLARE_AIM', 'TECS_LAND_SINK'];
export const knowsFlare = (parameters) => flareParameters.every((name) => Number.isFinite(parameters[name]));

// Places of a line, with longitudes near to another one: they may leave [-180, 180].
const placesOf = ({ coordinates }, near_deg) => coordinates.map(([longitude_deg, latitude_deg, altitude_m]) =>
  ({ latitude_deg, longitude_deg: nearTo(longitude_deg, near_deg), altitude_m }));

// The circle is told as a closed polygon with equal sides.
function centreOf(places) {
  const corners = places.slice(0, -1);
  const mean = (key) => corners.reduce((sum, corner) => sum + corner[key], 0) / corners.length;
  return { longitude_deg: mean('longitude_deg'), latitude_deg: mean('latitude_deg') };
}

function checked(landing) {
  if (landing.verdict === 'rejected') {
    throw new NoLanding(`the site is rejected: ${landing.reject_detail ?? 'no reason told'}`);
  }
  if (landing.altitude_datum !== 'amsl') {
    throw new NoLanding(`the site's altitudes are ${landing.altitude_datum}, not above mean sea level`);
  }
  const { touchdown, centre, start, radius_m } = landing;
  const numbers = [touchdown, centre, start]
    .flatMap((place) => [place?.latitude_deg, place?.longitude_deg, place?.altitude_m]);
  const isWhole = [...numbers, radius_m, landing.heading_deg].every(Number.isFinite);
  if (!isWhole) throw new NoLanding('the site has no whole approach');
  if (start.altitude_m <= touchdown.altitude_m) throw new NoLanding('the final does not descend');
  return landing;
}

// answer: of /v1/sites/{site}/approach. airspeed_mps: on the final, if known.
export function landingOfApproach(siteId, answer, airspeed_mps) {
  const feature = (kind) => answer.features?.find((one) => one.properties.kind === kind);
  const final = feature('approach');
  const circle = feature('loiter');
  if (!final || !circle) throw new NoLanding('the site has no approach');
  const near_deg = final.geometry.coordinates.at(-1)[0];
  const [start, touchdown] = placesOf(final.geometry, near_deg);
  return checked({
    site_id: siteId, hasPower: true, verdict: answer.verdict, reject_detail: answer.reject_detail, altitude_datum: answer.altitude_datum,
    touchdown, start, centre: { ...centreOf(placesOf(circle.geometry, near_deg)), altitude_m: start.altitude_m },
    radius_m: circle.properties.radius_m, isRight: circle.properties.direction === 'right',
    heading_deg: final.properties.heading_deg, ground_speed_mps: final.properties.ground_speed_mps,
    airspeed_mps: answer.plan?.aircraft?.landing_airspeed_mps ?? airspeed_mps,
  });
}

// site: of an answer of /v1/emergency, for an aircraft without power.
export function landingOfRecall(site) {
  const { approach, touchdown } = site;
  if (!approach?.loiter_center || !approach.start) throw new NoLanding('the site has no approach');
  const altitude_m = touchdown.altitude_m + approach.height_m;
  const near = (place) => ({ ...place, longitude_deg: nearTo(place.longitude_deg, touchdown.longitude_deg), altitude_m });
  return checked({
    site_id: site.site_id, hasPower: false, verdict: site.verdict, altitude_datum: site.altitude_datum, touchdown,
    start: near(approach.start), centre: near(approach.loiter_center),
    radius_m: approach.loiter_radius_m, isRight: approach.loiter_direction === 'right',
    heading_deg: approach.heading_deg, ground_speed_mps: site.ground_speed_mps ?? approach.ground_speed_mps,
    airspeed_mps: site.aircraft?.landing_airspeed_mps,
  });
}

function moved({ latitude_deg, longitude_deg, altitude_m }, heading_deg, distance_m) {
  const north_m = distance_m * Math.cos(radians(heading_deg));
  const east_m = distance_m * Math.sin(radians(heading_deg));
  return {
    latitude_deg: latitude_deg + north_m / metresPerDegree,
    longitude_deg: longitude_deg + east_m / (metresPerDegree * Math.cos(radians(latitude_deg))),
    altitude_m,
  };
}

// How far a flare goes, of the way to the ground on the final that it ends. With power the throttle
// is cut in it: in a recording of ArduPlane 36 m of 50. Without power nothing is cut: in the stand-in
// it ends where the final would.
const flareShare = { withPower: 0.72, withoutPower: 1 };

// Behind the touchdown, so that the aircraft touches it: ArduPlane flies a straight line from the end
// of the circle to a point above and before the LAND point, where it flares. parameters: of the
// autopilot; 0 if one of the flare is missing. own_mps: its airspeed on a final, if known.
// https://ardupilot.org/plane/docs/automatic-landing.html
export function landPointBehind_m(landing, parameters, own_mps = landing.airspeed_mps) {
  const { LAND_FLARE_SEC, LAND_FLARE_ALT, LAND_FLARE_AIM, TECS_LAND_SINK } = parameters;
  if (!knowsFlare(parameters) || !Number.isFinite(landing.ground_speed_mps)) return 0;
  const { start, touchdown } = landing;
  const faster_mps = Number.isFinite(own_mps - landing.airspeed_mps) ? own_mps - landing.airspeed_mps : 0;
  const groundSpeed_mps = Math.max(1, landing.ground_speed_mps + faster_mps);
  const slope = (start.altitude_m - touchdown.altitude_m) / finalLength_m(landing);
  const sink_mps = slope * groundSpeed_mps;
  const aim_m = Math.min(LAND_FLARE_SEC > 0 ? LAND_FLARE_SEC * sink_mps : LAND_FLARE_ALT, 2 * LAND_FLARE_ALT);
  const share = Math.min(1, Math.max(0, LAND_FLARE_AIM / 100));
  const flareSink_mps = Math.max(0.1, share * TECS_LAND_SINK + (1 - share) * sink_mps);
  const planned_m = (groundSpeed_mps * aim_m) / flareSink_mps;
  const flown_m = (flareShare[landing.hasPower ? 'withPower' : 'withoutPower'] * aim_m) / slope;
  return Math.max(0, planned_m - flown_m);
}

function finalLength_m({ start, touchdown }) {
  const north_m = (touchdown.latitude_deg - start.latitude_deg) * metresPerDegree;
  const east_m = (touchdown.longitude_deg - start.longitude_deg) * metresPerDegree *
    Math.cos(radians(touchdown.latitude_deg));
  return Math.max(1, Math.hypot(north_m, east_m));
}

const between = (a, b, share) => a + share * (b - a);

// A place on the final from which it is flown exactly: ArduPlane leaves the circle up to 30 degrees
// early, and takes its slope from there. Nearer to the centre than WP_LOITER_RAD it would end the
// circle at once, in any direction. Nothing if there is no such place on the first half.
function placeOnFinal({ start, touchdown, radius_m }, length_m, { WP_LOITER_RAD }) {
  if (!Number.isFinite(WP_LOITER_RAD)) return undefined;
  const tooNear_m = Math.sqrt(Math.max(0, (1.1 * WP_LOITER_RAD) ** 2 - radius_m ** 2));
  const share = Math.max(0.25, tooNear_m / length_m);
  if (share > 0.5) return undefined;
  return {
    latitude_deg: between(start.latitude_deg, touchdown.latitude_deg, share),
    longitude_deg: between(start.longitude_deg, touchdown.longitude_deg, share),
    altitude_m: between(start.altitude_m, touchdown.altitude_m, share),
  };
}

// home_altitude_m: for the height to which an aborted landing climbs.
// landing_airspeed_mps: of the autopilot, if known.
export function ardupilotItems(landing, { parameters = {}, home_altitude_m, landing_airspeed_mps } = {}) {
  const { touchdown, centre, start, heading_deg, radius_m, isRight } = landing;
  // Stored as a whole number of metres. A wider circle needs less bank.
  const radius = Math.ceil(radius_m - 0.25) * (isRight ? 1 : -1);
  const abort_m = home_altitude_m === undefined ? 0 : Math.max(1, Math.ceil(start.altitude_m - home_altitude_m));
  const behind_m = landPointBehind_m(landing, parameters, landing_airspeed_mps);
  const onFinal = placeOnFinal(landing, finalLength_m(landing), parameters);
  return [
    item(MavCmd.DO_LAND_START, centre),
    item(MavCmd.NAV_LOITER_TO_ALT, centre, [0, radius, 0, 1]),
    ...(onFinal ? [item(MavCmd.NAV_WAYPOINT, onFinal)] : []),
    // Read back as 1 unless it is negative: the direction of a deep stall.
    item(MavCmd.NAV_LAND, moved(touchdown, heading_deg, behind_m), [abort_m, 0, 0, 1]),
  ];
}

// PX4 judges a mission as it takes it: a final steeper than FW_LND_ANG, or a LAND within the circle, and the
// whole mission is not flown. Commands without a place are taken in one frame only.
// https://docs.px4.io/main/en/flight_modes_fw/mission.html
const slopeTolerance_deg = 0.1;

export function px4Items(landing, { parameters = {} } = {}) {
  const { touchdown, centre, start, radius_m, isRight } = landing;
  const slope_deg = Math.atan2(start.altitude_m - touchdown.altitude_m, finalLength_m(landing)) / radians(1);
  const { FW_LND_ANG } = parameters;
  if (slope_deg > FW_LND_ANG + slopeTolerance_deg) {
    throw new NoLanding(`the final descends by ${slope_deg.toFixed(1)} degrees, the autopilot takes at most ${FW_LND_ANG.toFixed(1)} (FW_LND_ANG)`);
  }
  // param1: it leaves the circle in the direction of the next item.
  return [
    item(MavCmd.DO_LAND_START, undefined, [], MavFrame.MISSION),
    item(MavCmd.NAV_LOITER_TO_ALT, centre, [1, radius_m * (isRight ? 1 : -1), 0, 1]),
    item(MavCmd.NAV_LAND, touchdown, [0, 0, 0, NaN]),
  ];
}
