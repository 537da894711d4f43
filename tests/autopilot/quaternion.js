// An attitude as the service stores it: ned_from_body as w, x, y, z, with w not negative.

export function quaternionOf({ roll_deg, pitch_deg, yaw_deg }) {
  const [r, p, y] = [roll_deg, pitch_deg, yaw_deg].map((angle_deg) => (angle_deg * Math.PI) / 360);
  const { cos, sin } = Math;
  const parts = [cos(r) * cos(p) * cos(y) + sin(r) * sin(p) * sin(y), sin(r) * cos(p) * cos(y) - cos(r) * sin(p) * sin(y),
    cos(r) * sin(p) * cos(y) + sin(r) * cos(p) * sin(y), cos(r) * cos(p) * sin(y) - sin(r) * sin(p) * cos(y)];
  return parts[0] < 0 ? parts.map((part) => -part) : parts;
}
