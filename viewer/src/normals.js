// Normals of faces, and of corners: averaged over the faces around a vertex that do not bend away by more than a crease.

const CREASE = 35;

/** Unit normals of polygons (Newell); zero without area. */
export function faceNormals(points, { count, offsets, corners }) {
  const out = new Float32Array(3 * count);
  for (let f = 0; f < count; f++) {
    let [x, y, z] = [0, 0, 0];
    const origin = 3 * corners[offsets[f]];
    for (let c = offsets[f] + 1; c + 1 < offsets[f + 1]; c++) {
      const [p, q] = [3 * corners[c], 3 * corners[c + 1]];
      const [ux, uy, uz] = [points[p] - points[origin], points[p + 1] - points[origin + 1], points[p + 2] - points[origin + 2]];
      const [vx, vy, vz] = [points[q] - points[origin], points[q + 1] - points[origin + 1], points[q + 2] - points[origin + 2]];
      x += uy * vz - uz * vy;
      y += uz * vx - ux * vz;
      z += ux * vy - uy * vx;
    }
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    out[3 * f] = x / length;
    out[3 * f + 1] = y / length;
    out[3 * f + 2] = z / length;
  }
  return out;
}

/** Normals at the corners of a soup of faces, as signed bytes in fours. */
export function cornerNormals(soup, normals, vertexCount) {
  const { corners, owner } = soup;
  const start = new Uint32Array(vertexCount + 1);
  for (let c = 0; c < corners.length; c++) start[corners[c] + 1]++;
  for (let v = 0; v < vertexCount; v++) start[v + 1] += start[v];
  const fill = start.slice(0, vertexCount);
  const around = new Uint32Array(corners.length);
  for (let c = 0; c < corners.length; c++) around[fill[corners[c]]++] = owner[(c / 3) | 0];
  const limit = Math.cos((CREASE * Math.PI) / 180);
  const out = new Int8Array(4 * corners.length);
  for (let c = 0; c < corners.length; c++) {
    // Plain numbers: this loop runs millions of times.
    const f = 3 * owner[(c / 3) | 0];
    const nx = normals[f];
    const ny = normals[f + 1];
    const nz = normals[f + 2];
    let x = 0;
    let y = 0;
    let z = 0;
    const end = start[corners[c] + 1];
    for (let k = start[corners[c]]; k < end; k++) {
      const g = 3 * around[k];
      if (nx * normals[g] + ny * normals[g + 1] + nz * normals[g + 2] < limit) continue;
      x += normals[g];
      y += normals[g + 1];
      z += normals[g + 2];
    }
    const length = Math.sqrt(x * x + y * y + z * z) || 1;
    out[4 * c] = Math.round((127 * x) / length);
    out[4 * c + 1] = Math.round((127 * y) / length);
    out[4 * c + 2] = Math.round((127 * z) / length);
  }
  return out;
}
