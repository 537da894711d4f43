// The surveys that a service has sites of: where they are, and what the altimeter of the aircraft
// that flew them had wrong, which the heights of their sites have too.

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const mean = (values) => values.reduce((sum, value) => sum + value, 0) / values.length;

// [{ flight_id, centre, height_error_m }]
export function surveysOf(sites, ground) {
  const flights = new Map();
  for (const { geometry, properties } of sites.features) {
    const [longitude_deg, latitude_deg, altitude_m] = geometry.coordinates;
    const place = { latitude_deg, longitude_deg };
    const list = flights.get(properties.flight_id) ?? [];
    list.push({ ...place, height_error_m: altitude_m - ground.altitude_m(place) });
    flights.set(properties.flight_id, list);
  }
  return [...flights].map(([flight_id, list]) => ({
    flight_id,
    centre: { latitude_deg: mean(list.map((site) => site.latitude_deg)), longitude_deg: mean(list.map((site) => site.longitude_deg)) },
    height_error_m: median(list.map((site) => site.height_error_m)),
  }));
}
