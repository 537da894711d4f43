// Missions for the stand-in, in its own local frame: { east_m, north_m, height_m above home }.

import { command } from './items.js';

const relative = 3;

export function item(plane, id, { east_m = 0, north_m = 0, height_m = 0 }, params = []) {
  const { latitude_deg, longitude_deg } = plane.frame.toGlobal({ east_m, north_m });
  const [param1 = 0, param2 = 0, param3 = 0, param4 = 0] = params;
  return { frame: relative, command: id, param1, param2, param3, param4,
    x: Math.round(latitude_deg * 1e7), y: Math.round(longitude_deg * 1e7), z: height_m };
}

const home = (plane) => item(plane, command.waypoint, {});

// Lines to and fro over a rectangle, again and again.
export function survey(plane, { west_m = -300, south_m = -300, width_m = 600, length_m = 600, spacing_m = 60,
  height_m = 120, repeats = -1, withTakeoff = false } = {}) {
  const items = [home(plane)];
  if (withTakeoff) items.push(item(plane, command.takeoff, { height_m: height_m / 2 }, [12]));
  const first = items.length;
  const numLines = Math.floor(width_m / spacing_m) + 1;
  for (let line = 0; line < numLines; ++line) {
    const east_m = west_m + line * spacing_m;
    const ends = [south_m, south_m + length_m];
    if (line % 2) ends.reverse();
    for (const north_m of ends) items.push(item(plane, command.waypoint, { east_m, north_m, height_m }));
  }
  items.push({ frame: relative, command: command.jump, param1: first, param2: repeats, param3: 0, param4: 0, x: 0, y: 0, z: 0 });
  return items;
}

// Runs from the circle to the LAND point; heading_deg of the final.
export function landing(plane, { east_m = 60, north_m = 0, heading_deg = 90, final_m = 600, final_height_m = 40,
  circle_height_m = 60, radius_m = 90 } = {}) {
  const heading_rad = (heading_deg * Math.PI) / 180;
  const back = (distance_m, right_m = 0) => ({
    east_m: east_m - distance_m * Math.sin(heading_rad) + right_m * Math.cos(heading_rad),
    north_m: north_m - distance_m * Math.cos(heading_rad) - right_m * Math.sin(heading_rad),
  });
  return [
    { ...item(plane, command.landStart, {}), x: 0, y: 0 },
    item(plane, command.loiterToAltitude, { ...back(final_m + 400, -radius_m), height_m: circle_height_m }, [0, radius_m, 0, 1]),
    item(plane, command.waypoint, { ...back(final_m), height_m: final_height_m }),
    item(plane, command.land, { east_m, north_m, height_m: 0 }),
  ];
}
