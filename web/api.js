// The only file that calls fetch. Names and units are those of the JSON.

async function getJson(path) {
  const response = await fetch(path, { headers: { Accept: 'application/json' } });
  if (!response.ok) {
    const problem = await response.json().catch(() => ({}));
    throw Object.assign(new Error(problem.detail ?? response.statusText), {
      status: response.status,
      code: problem.code,
    });
  }
  return response.json();
}

const part = encodeURIComponent;

export const listFlights = async () => (await getJson('/v1/flights')).flights;
export const getFlight = (flight) => getJson(`/v1/flights/${part(flight)}`);
export const getRegions = (flight) => getJson(`/v1/flights/${part(flight)}/regions`);
export const getSites = (flight) => getJson(`/v1/flights/${part(flight)}/sites`);
export const getSite = (site) => getJson(`/v1/sites/${part(site)}`);
export const getLayers = async (site) => (await getJson(`/v1/sites/${part(site)}/layers`)).layers;
export const listJobs = async () => (await getJson('/v1/jobs')).jobs;
export const layerUrl = (site, layer) => `/v1/sites/${part(site)}/layers/${part(layer)}.png`;
export const legendUrl = (site, layer) =>
  `/v1/sites/${part(site)}/layers/${part(layer)}/legend.png`;

// Nothing for a site that has no approach (409).
export async function getApproach(site) {
  try {
    return await getJson(`/v1/sites/${part(site)}/approach`);
  } catch (error) {
    if (error.status === 409) return null;
    throw error;
  }
}
