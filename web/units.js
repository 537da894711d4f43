// Formats numbers with units. Unknown values read "unknown", never 0.

export const isKnown = (value) => value !== null && value !== undefined && Number.isFinite(value);

export const fixed = (value, digits, unit = '') =>
  isKnown(value) ? `${value.toFixed(digits)}${unit && unit !== '°' ? ' ' : ''}${unit}` : 'unknown';

// "+86 m", "−12 m": a height above or below the needed one. Rounded down, so that it never promises more.
export const margin = (value_m) => (isKnown(value_m)
  ? `${Math.floor(value_m) >= 0 ? '+' : '−'}${Math.abs(Math.floor(value_m))} m` : 'unknown');

export const words = (name) => name.replaceAll('_', ' ');

export function area(value_m2) {
  if (!isKnown(value_m2)) return 'unknown';
  return value_m2 >= 10000 ? `${(value_m2 / 10000).toFixed(1)} ha` : `${Math.round(value_m2)} m²`;
}

// "180 × 35 m": rounded down, because a strip is never longer than it was measured.
export const strip = ({ usable_length_m, usable_width_m }) =>
  isKnown(usable_length_m) && isKnown(usable_width_m)
    ? `${Math.floor(usable_length_m)} × ${Math.floor(usable_width_m)} m` : 'unknown';

export function distance(value_m) {
  if (!isKnown(value_m)) return 'unknown';
  return value_m >= 2000 ? `${(value_m / 1000).toFixed(1)} km` : `${Math.round(value_m)} m`;
}

// 7 -> "007°": aviation writes headings with three digits.
export const heading = (value_deg) =>
  isKnown(value_deg) ? `${String(Math.round(value_deg) % 360).padStart(3, '0')}°` : 'unknown';

export function age(seconds) {
  if (!isKnown(seconds)) return 'unknown';
  const year_s = 365.25 * 86400;
  if (seconds >= 2 * year_s) return `${Math.floor(seconds / year_s)} years`;
  const steps = [[86400, 'd'], [3600, 'h'], [60, 'min']];
  for (const [size, unit] of steps) {
    if (seconds >= size) return `${Math.floor(seconds / size)} ${unit}`;
  }
  return `${Math.max(0, Math.round(seconds))} s`;
}

// Since the ground of a site was last photographed; NaN if unknown. p: properties of the site.
export const groundAge_s = (p) => p.new_look?.age_s ?? p.age_s ?? (Date.now() - Date.parse(p.last_seen_at)) / 1000;
export const photographed = (p) => {
  const age_s = groundAge_s(p);
  return isKnown(age_s) ? `photographed ${age(age_s)} ago` : 'date unknown';
};

// "14:05", in the user's own time zone.
export const clockOf = (time) => new Date(time).toLocaleTimeString([], { hour: '2-digit', minute: '2-digit', hourCycle: 'h23' });

export function bytes(count) {
  return count >= 1 << 20 ? `${(count / (1 << 20)).toFixed(1)} MiB` : `${Math.ceil(count / 1024)} KiB`;
}

export const verdictSign = { landable: '✓', unverified: '?', rejected: '✕' };

// JSON states where the air moves to. Pilots state where the wind comes from.
export function windFrom(wind) {
  if (!wind) return null;
  const speed_mps = Math.hypot(wind.east_mps, wind.north_mps);
  const from_deg = (Math.atan2(-wind.east_mps, -wind.north_mps) * 180 / Math.PI + 360) % 360;
  return { speed_mps, from_deg };
}

export function windTo(speed_mps, from_deg) {
  const to_rad = (from_deg + 180) * Math.PI / 180;
  return { east_mps: speed_mps * Math.sin(to_rad), north_mps: speed_mps * Math.cos(to_rad) };
}

export function windText(wind) {
  const from = windFrom(wind);
  if (!from) return 'unknown';
  if (from.speed_mps < 0.05) return 'calm';
  return `${from.speed_mps.toFixed(1)} m/s from ${heading(from.from_deg)}`;
}

const earthRadius_m = 6371008.8;
// Of the sites of an emergency answer. Numbers would be read as ranks within a flight, whose order is another.
export const siteLetter = (index) => String.fromCharCode(65 + index);

const rad = (deg) => deg * Math.PI / 180;

// Great circle from a to b, each {latitude_deg, longitude_deg}.
export function courseTo(a, b) {
  const [lat1, lat2] = [rad(a.latitude_deg), rad(b.latitude_deg)];
  const dLon = rad(b.longitude_deg - a.longitude_deg);
  const h = Math.sin((lat2 - lat1) / 2) ** 2 +
    Math.cos(lat1) * Math.cos(lat2) * Math.sin(dLon / 2) ** 2;
  const bearing = Math.atan2(Math.sin(dLon) * Math.cos(lat2),
    Math.cos(lat1) * Math.sin(lat2) - Math.sin(lat1) * Math.cos(lat2) * Math.cos(dLon));
  return {
    distance_m: 2 * earthRadius_m * Math.asin(Math.min(1, Math.sqrt(h))),
    bearing_deg: (bearing * 180 / Math.PI + 360) % 360,
  };
}
