// What is under the pointer: the nearest triangle of the drawn soup, or a node of a net.

/** Parameters of a ray in local coordinates. */
export function pickFace(skin, origin, direction, options) {
  const { model, soup } = skin;
  const { points } = model;
  const { shrink, plane, layer, range } = options;
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  const isKept = (t) => {
    if (!range || model.isVolume || layer.on === 'vertex') return true;
    const value = layer.values[soup.owner[t]];
    return value >= range[0] && value <= range[1];
  };
  let best = Infinity;
  let found = -1;
  const p = new Float64Array(9);
  for (let t = 0; t < soup.count; t++) {
    for (let k = 0; k < 3; k++) {
      const v = 3 * soup.corners[3 * t + k];
      p[3 * k] = points[v];
      p[3 * k + 1] = points[v + 1];
      p[3 * k + 2] = points[v + 2];
    }
    if (shrink < 1 && model.isVolume) {
      const c = 3 * soup.owner[t];
      for (let k = 0; k < 9; k++) p[k] = model.cellFaces.centres[c + (k % 3)] * (1 - shrink) + p[k] * shrink;
    }
    // Möller and Trumbore.
    const [ux, uy, uz] = [p[3] - p[0], p[4] - p[1], p[5] - p[2]];
    const [vx, vy, vz] = [p[6] - p[0], p[7] - p[1], p[8] - p[2]];
    const [hx, hy, hz] = [dy * vz - dz * vy, dz * vx - dx * vz, dx * vy - dy * vx];
    const det = ux * hx + uy * hy + uz * hz;
    if (det === 0) continue;
    const [sx, sy, sz] = [ox - p[0], oy - p[1], oz - p[2]];
    const a = (sx * hx + sy * hy + sz * hz) / det;
    if (a < 0 || a > 1) continue;
    const [qx, qy, qz] = [sy * uz - sz * uy, sz * ux - sx * uz, sx * uy - sy * ux];
    const b = (dx * qx + dy * qy + dz * qz) / det;
    if (b < 0 || a + b > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / det;
    if (distance <= 0 || distance >= best) continue;
    if (plane && !model.isVolume) {
      const along = plane.n[0] * (ox + distance * dx) + plane.n[1] * (oy + distance * dy) + plane.n[2] * (oz + distance * dz);
      if (along > plane.d) continue;
    }
    if (!isKept(t)) continue;
    best = distance;
    found = t;
  }
  if (found < 0) return null;
  const point = [ox + best * dx, oy + best * dy, oz + best * dz];
  const on = model.isVolume ? 'cell' : 'face';
  return { on, id: soup.owner[found], face: soup.face[found], point, distance: best };
}

/** The node of a net nearest to the pointer, within some pixels; `project` gives pixels from local coordinates. */
export function pickNode(model, project, x, y, within = 9) {
  let best = within;
  let found = null;
  model.nets.forEach((net, n) => {
    for (let v = 0; v < net.points.length / 3; v++) {
      const point = [net.points[3 * v], net.points[3 * v + 1], net.points[3 * v + 2]];
      const [px, py] = project(point);
      const away = Math.hypot(px - x, py - y);
      if (away < best) {
        best = away;
        found = { on: 'node', id: v, net: n, point, radius: net.radii[v] };
      }
    }
  });
  return found;
}
