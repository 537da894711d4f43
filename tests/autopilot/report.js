// Figures for RESULTS.md: one JSON line each in the file that FREELSD_REPORT names.

import { appendFileSync } from 'node:fs';

export function report(subject, figure, value) {
  const path = process.env.FREELSD_REPORT;
  if (path) appendFileSync(path, `${JSON.stringify({ subject, figure, value })}\n`);
}
