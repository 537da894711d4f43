// The way to a site as emergency recall tells it: where on it an aircraft is, and what lies ahead.
// Pure: no sockets, no clock.

import { FlatFrame } from './flat_frame.js';

// The service writes places of one path to a centimetre.
const samePlace_m = 0.2;
const sameFinal_m = 0.5;

const gap = (a, b) => Math.hypot(b.east_m - a.east_m, b.north_m - a.north_m);
const between = (a, b, share) => a + share * (b - a);

function pointsOf(path, times_s, frame) {
  let along_m = 0;
  let last;
  return path.coordinates.map(([longitude_deg, latitude_deg, altitude_m], i) => {
    const place = frame.toLocal({ latitude_deg, longitude_deg });
    if (last) along_m += gap(last, place);
    last = place;
    return { ...place, altitude_m, along_m, time_s: times_s[i] };
  });
}

export class ToldWay {
  #frame;
  #points;
  site;
  // Along the way, metres: where it first comes over the start of the final, where the final
  // begins after the circles, and the touchdown.
  arrival_m;
  finalStart_m;
  end_m;

  // site: of an answer of /v1/emergency, with path and times_s.
  constructor(site) {
    this.site = site;
    this.#frame = new FlatFrame(site.touchdown);
    this.#points = pointsOf(site.path, site.times_s, this.#frame);
    const start = this.#points.at(-2);
    this.arrival_m = this.#points.find((point) => gap(point, start) < samePlace_m).along_m;
    this.finalStart_m = start.along_m;
    this.end_m = this.#points.at(-1).along_m;
  }

  get finalStartAltitude_m() { return this.#points.at(-2).altitude_m; }
  get length_m() { return this.end_m; }
  // Height of the way above the planned start of the final.
  get surplus_m() { return this.#points.at(-2).altitude_m - this.site.approach.start.altitude_m; }

  get numCircles() {
    const circle_m = 2 * Math.PI * this.site.approach.loiter_radius_m;
    return Math.round((this.finalStart_m - this.arrival_m) / circle_m);
  }

  // The same way with one more circle before the final; nothing if the circle is not told.
  withCircle(glideRatio, airspeed_mps) {
    const { approach, path, times_s } = this.site;
    const turn = circlePoints(this.#frame, approach, { glideRatio, airspeed_mps });
    const start = path.coordinates.at(-2);
    const added = turn.map(({ east_m, north_m, lost_m }) => {
      const { latitude_deg, longitude_deg } = this.#frame.toGlobal({ east_m, north_m });
      return [longitude_deg, latitude_deg, start[2] - lost_m];
    });
    const startTime_s = times_s.at(-2);
    const later_s = turn.at(-1).time_s;
    return new ToldWay({
      ...this.site,
      path: { ...path, coordinates: [...path.coordinates.slice(0, -1), ...added, path.coordinates.at(-1)] },
      times_s: [...times_s.slice(0, -1), ...turn.map((point) => startTime_s + point.time_s), times_s.at(-1) + later_s],
    });
  }

  // Where the way is nearest between two lengths along it. right_m: of the way, positive;
  // height_m: the aircraft's above the way.
  nearest(position, from_m = 0, to_m = this.end_m) {
    const here = this.#frame.toLocal(position);
    let best;
    for (let i = 1; i < this.#points.length; ++i) {
      const [a, b] = [this.#points[i - 1], this.#points[i]];
      if (b.along_m < from_m || a.along_m > to_m) continue;
      const found = nearestOnLeg(here, a, b);
      if (!best || found.away_m < best.away_m) best = found;
    }
    best ??= nearestOnLeg(here, this.#points.at(-2), this.#points.at(-1));
    const { altitude_m, time_s } = this.#at(best.along_m);
    return { ...best, time_s, height_m: position.altitude_m - altitude_m };
  }

  // A place on the way; beyond its end on the line of the final, level with the touchdown.
  at(along_m) {
    const point = this.#at(along_m);
    return { ...this.#frame.toGlobal(point), altitude_m: point.altitude_m, time_s: point.time_s };
  }

  // Clockwise from north.
  heading_deg(along_m) {
    const i = this.#legAt(along_m);
    const [a, b] = [this.#points[i - 1], this.#points[i]];
    return (Math.atan2(b.east_m - a.east_m, b.north_m - a.north_m) * 180) / Math.PI;
  }

  // Seconds from there to the start of the final.
  timeToFinal_s(along_m) {
    return Math.max(0, this.#points.at(-2).time_s - this.#at(along_m).time_s);
  }

  timeToTouchdown_s(along_m) { return this.#points.at(-1).time_s - this.#at(along_m).time_s; }

  #legAt(along_m) {
    const i = this.#points.findIndex((point, k) => k > 0 && point.along_m >= along_m);
    return i < 0 ? this.#points.length - 1 : i;
  }

  #at(along_m) {
    const i = this.#legAt(along_m);
    const [a, b] = [this.#points[i - 1], this.#points[i]];
    const length_m = Math.max(1e-6, b.along_m - a.along_m);
    const share = Math.max(0, (along_m - a.along_m) / length_m);
    const inside = Math.min(1, share);
    return {
      east_m: between(a.east_m, b.east_m, share),
      north_m: between(a.north_m, b.north_m, share),
      altitude_m: between(a.altitude_m, b.altitude_m, inside),
      time_s: between(a.time_s, b.time_s, inside),
    };
  }
}

function nearestOnLeg(here, a, b) {
  const length_m = Math.max(1e-6, gap(a, b));
  const east = (b.east_m - a.east_m) / length_m;
  const north = (b.north_m - a.north_m) / length_m;
  const x = here.east_m - a.east_m;
  const y = here.north_m - a.north_m;
  const along = Math.min(length_m, Math.max(0, x * east + y * north));
  return {
    along_m: a.along_m + along,
    away_m: Math.hypot(x - along * east, y - along * north),
    right_m: x * north - y * east,
  };
}

const samePlaceAs = (a, b) => gap(new FlatFrame(a).toLocal(b), { east_m: 0, north_m: 0 }) < sameFinal_m &&
  Math.abs(a.altitude_m - b.altitude_m) < sameFinal_m;

// Another wind may move the final of a site.
export const isSameFinal = (a, b) => samePlaceAs(a.touchdown, b.touchdown) &&
  samePlaceAs(a.approach.start, b.approach.start);

const numCirclePoints = 36;
const gravity_mps2 = 9.81;

// From the start of the final once around the circle of the approach. lost_m: as recall counts it,
// all drag is induced.
function circlePoints(frame, approach, { glideRatio, airspeed_mps }) {
  const centre = frame.toLocal(approach.loiter_center);
  const start = frame.toLocal(approach.start);
  const radius_m = approach.loiter_radius_m;
  const side = approach.loiter_direction === 'right' ? 1 : -1;
  const first_rad = Math.atan2(start.east_m - centre.east_m, start.north_m - centre.north_m);
  const load = airspeed_mps ** 2 / (gravity_mps2 * radius_m);
  return Array.from({ length: numCirclePoints }, (_, i) => {
    const share = (i + 1) / numCirclePoints;
    const angle_rad = first_rad + side * share * 2 * Math.PI;
    const flown_m = share * 2 * Math.PI * radius_m;
    return {
      east_m: centre.east_m + radius_m * Math.sin(angle_rad),
      north_m: centre.north_m + radius_m * Math.cos(angle_rad),
      lost_m: (flown_m / glideRatio) * (1 + load ** 2),
      time_s: flown_m / airspeed_mps,
    };
  });
}
