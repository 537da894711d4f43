// Which optional parts this server answers, by its own API description. A part that it lacks is never
// asked for: the page then shows no trace of it.

import { getOpenApi } from './api.js';

const hasParameter = (operation, name) => (operation?.parameters ?? []).some((parameter) =>
  parameter.name === name || parameter.$ref?.split('/').at(-1) === name);

export function offersOf({ paths = {} }) {
  const ofFlight = (name) => Object.keys(paths).some((path) => new RegExp(`^/v1/flights/\\{[^}]+\\}/${name}$`).test(path));
  return {
    flightMap: ofFlight('map'),
    flightWhy: ofFlight('why'),
    landing: ofFlight('landing'),
    nextLook: ofFlight('next-look'),
    baseMap: '/v1/base-map' in paths,
    reach: '/v1/reach' in paths,
    reachLimit: hasParameter(paths['/v1/reach']?.get, 'limit'),
    links: '/v1/links' in paths,
    notices: '/v1/notices' in paths,
    obstacles: '/v1/obstacles' in paths,
    routeCheck: '/v1/routes/check' in paths,
    newLook: hasParameter(paths['/v1/sites']?.get, 'order'),
  };
}

let asked = null;

// Booleans, as offersOf names them. reachLimit: the number of sites of a reach can be set.
// Asks the server once; a failed request is repeated at the next call.
export function offers() {
  asked ??= getOpenApi().then(offersOf).catch((error) => {
    asked = null;
    throw error;
  });
  return asked;
}
