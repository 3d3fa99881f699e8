// What is under the pointer: the nearest triangle of the drawn soup, or a node of a net.

/** The nearest triangle that a ray meets (local coordinates), among those that are drawn. */
export function pickFace(skin, origin, direction, options) {
  const { model, soup } = skin;
  const { points } = model;
  const { shrink, plane, layer, range } = options;
  const [ox, oy, oz] = origin;
  const [dx, dy, dz] = direction;
  const isKept = (t) => {
    if (model.isVolume) return skin.visible[soup.owner[t]] === 1;
    if (!range || layer.on === 'vertex') return true;
    const value = layer.values[soup.owner[t]];
    return value >= range[0] && value <= range[1];
  };
  let best = Infinity;
  let found = -1;
  const isShrunk = shrink < 1 && model.isVolume;
  // Plain numbers: this loop runs over all triangles.
  for (let t = 0; t < soup.count; t++) {
    const a = 3 * soup.corners[3 * t];
    const b = 3 * soup.corners[3 * t + 1];
    const c = 3 * soup.corners[3 * t + 2];
    let px = points[a];
    let py = points[a + 1];
    let pz = points[a + 2];
    let ux = points[b] - px;
    let uy = points[b + 1] - py;
    let uz = points[b + 2] - pz;
    let vx = points[c] - px;
    let vy = points[c + 1] - py;
    let vz = points[c + 2] - pz;
    if (isShrunk) {
      const m = 3 * soup.owner[t];
      const { centres } = model.cellFaces;
      px = centres[m] + (px - centres[m]) * shrink;
      py = centres[m + 1] + (py - centres[m + 1]) * shrink;
      pz = centres[m + 2] + (pz - centres[m + 2]) * shrink;
      ux *= shrink; uy *= shrink; uz *= shrink;
      vx *= shrink; vy *= shrink; vz *= shrink;
    }
    // Möller and Trumbore.
    const hx = dy * vz - dz * vy;
    const hy = dz * vx - dx * vz;
    const hz = dx * vy - dy * vx;
    const det = ux * hx + uy * hy + uz * hz;
    if (det === 0) continue;
    const sx = ox - px;
    const sy = oy - py;
    const sz = oz - pz;
    const first = (sx * hx + sy * hy + sz * hz) / det;
    if (first < 0 || first > 1) continue;
    const qx = sy * uz - sz * uy;
    const qy = sz * ux - sx * uz;
    const qz = sx * uy - sy * ux;
    const second = (dx * qx + dy * qy + dz * qz) / det;
    if (second < 0 || first + second > 1) continue;
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
