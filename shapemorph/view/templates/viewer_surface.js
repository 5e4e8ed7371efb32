// The measured surface: unpacking it, its triangles, normals and values.

function unpackSurface(about, text) {
  const raw = atob(text.trim());
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  const kinds = { f4: Float32Array, u4: Uint32Array, u1: Uint8Array };
  const array = (name) => {
    const { offset, count, kind } = about.arrays[name];
    return new kinds[kind](bytes.buffer, offset, count);
  };
  const surface = {
    shown: about.shown, // points of the surface; those after them were lost
    row: array("row"),
    reference: array("reference"),
    displacement: array("displacement"),
    status: array("status"),
    stored: (key) => (about.arrays["value " + key] ? array("value " + key) : null),
    triangles: splitQuads(array("quads")),
  };
  surface.count = surface.row.length;
  surface.normals = [0, 1].map((state) => pointNormals(surface, state));
  return surface;
}

function splitQuads(quads) {
  const triangles = new Uint32Array((quads.length / 4) * 6);
  for (let q = 0, t = 0; q < quads.length; q += 4, t += 6) {
    triangles.set([quads[q], quads[q + 1], quads[q + 2], quads[q], quads[q + 2], quads[q + 3]], t);
  }
  return triangles;
}

// Position of a point between the reference (state 0) and the deformed shape (state 1).
function positionOf(surface, point, state, out) {
  for (let k = 0; k < 3; k++) {
    const moved = state ? state * surface.displacement[3 * point + k] : 0;
    out[k] = surface.reference[3 * point + k] + moved;
  }
  return out;
}

// Sums of the normals of the triangles around each point, of length 1.
function pointNormals(surface, state) {
  const normals = new Float32Array(3 * surface.shown);
  const corners = [new Float64Array(3), new Float64Array(3), new Float64Array(3)];
  for (let t = 0; t < surface.triangles.length; t += 3) {
    const [a, b, c] = corners;
    corners.forEach((corner, k) => positionOf(surface, surface.triangles[t + k], state, corner));
    const normal = cross(minus(b, a), minus(c, a));
    for (let k = 0; k < 3; k++) {
      const at = 3 * surface.triangles[t + k];
      for (let j = 0; j < 3; j++) normals[at + j] += normal[j];
    }
  }
  for (let n = 0; n < normals.length; n += 3) {
    const length = Math.hypot(normals[n], normals[n + 1], normals[n + 2]) || 1;
    for (let j = 0; j < 3; j++) normals[n + j] /= length;
  }
  return normals;
}

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

// Values of a field at every point, NaN where lost.
function fieldValues(surface, field) {
  const stored = surface.stored(field.key);
  if (stored) return stored;
  const values = new Float32Array(surface.count);
  const component = { displacement_u: 0, displacement_v: 1, displacement_w: 2 }[field.key];
  for (let n = 0; n < surface.count; n++) {
    const [u, v, w] = surface.displacement.subarray(3 * n, 3 * n + 3);
    values[n] = component === undefined ? Math.hypot(u, v, w) : [u, v, w][component];
  }
  return values;
}
