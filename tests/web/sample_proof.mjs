// A sample answer of `why` that tells what a place of the map was made of.

import { png, sampleWhy } from './sample_map.mjs';

export const samplePatch = (frame) => png(64, 64, (x, y) => (x < 8 && frame === 'IMG_7.JPG' ? [0, 0, 0, 255]
  : [90 + 30 * Math.sin(x / 3), 140 + 40 * Math.cos((x + y) / 5), 60 + frame.length, 255]));

const heights_m = Array.from({ length: 33 }, (_, i) => 458.2 + 0.125 * i);

// A likelihood that is best at 460.2 m.
export const sampleLikelihood = {
  height_m: heights_m, log_likelihood: heights_m.map((height) => -90 * (1 - Math.exp(-4 * (height - 460.2) ** 2))),
  num_views: 5, baseline_ratio: 0.42, correlation: 0.871,
};

const patch = (flight, number, weight) => ({
  frame_id: `IMG_${number}.JPG`, x_px: 352.6, y_px: 744.8, weight,
  url: `/v1/flights/${flight}/frames/IMG_${number}.JPG/patch.png?x_px=352.6&y_px=744.8&side_px=240.0` });

// weights: of its photographs. evidence, more: what differs.
export const sampleProof = (flight, { weights = [0.404, 0.275, 0.225, 0.096], evidence = {}, ...more } = {}) => {
  const patches = weights.map((weight, i) => patch(flight, 7 + i, weight));
  return {
    ...sampleWhy,
    evidence: {
      ...sampleWhy.evidence, risk: 0.024, frames: patches.map(({ frame_id }) => frame_id), patches, context_frames: ['IMG_3.JPG', 'IMG_4.JPG'],
      height_likelihood: sampleLikelihood,
      cues: [{ cue: 'fence', log_odds: null, denies: true }, { cue: 'views', log_odds: 7.875, denies: false },
        { cue: 'look_alike', log_odds: -1.5, denies: false }, { cue: 'small_object', log_odds: 0, denies: false },
        { cue: 'fence', log_odds: null, denies: false }],
      ...evidence,
    },
    nearest_limit: { part: 'ground', value: 0.024, limit: 0.1, margin: 0.076, whole: 0.024 },
    options: { terrain: { cell_size_m: 0.5 } },
    versions: { program: '0.1.0', grass_model_sha256: 'b4cc5bf82e25cbcd95f43996a5f1837d', map: `${flight}/2`, evaluated_at: '2026-11-27T09:55:18Z' },
    altitude_datum: 'amsl', ...more,
  };
};
