// What the person should know of a landing in this autopilot. A parameter is never written: the person decides.

import { knowsFlare } from './landing_items.js';

const maxSpeedDifference_mps = 1;

// landing: as of landing_items.js. The rest: of the aircraft, as the keeper knows it.
export function warningsOf({ airspeed_mps: planned_mps }, { landing_airspeed_mps: own_mps, isArdupilot, parameters }) {
  const warnings = [];
  if (isArdupilot && !knowsFlare(parameters)) warnings.push('the autopilot\'s flare is not known: the final is flown lower than it was checked');
  if (!isArdupilot && parameters.FW_LND_ANG === undefined) warnings.push('it is not known how steep a final the autopilot takes');
  if (!isArdupilot) warnings.push('landings with PX4 have not been flown');
  if (own_mps === undefined) warnings.push('the autopilot\'s landing airspeed is not known');
  else if (Math.abs(own_mps - planned_mps) > maxSpeedDifference_mps) {
    warnings.push(`the autopilot lands at ${own_mps.toFixed(1)} m/s, the site was planned for ${planned_mps.toFixed(1)} m/s`);
  }
  return warnings;
}
