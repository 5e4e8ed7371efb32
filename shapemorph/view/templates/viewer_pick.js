// Which point of the surface lies under the pointer.

// The nearest corner of the foremost triangle there, else a lost point close by; -1: none.
function pickPoint(surface, camera, x, y) {
  const place = new Float32Array(3 * surface.count);
  projectAll(surface, camera, place);
  const triangle = foremostTriangle(surface, place, x, y);
  if (triangle >= 0) {
    return nearestPoint(place, surface.triangles.subarray(triangle, triangle + 3), x, y, Infinity);
  }
  if (camera.state !== 0) return -1;
  const lost = Array.from({ length: surface.count - surface.shown }, (_, n) => surface.shown + n);
  return nearestPoint(place, lost, x, y, 8);
}

function foremostTriangle(surface, place, x, y) {
  let best = -1;
  let front = -Infinity;
  for (let t = 0; t < surface.triangles.length; t += 3) {
    const [a, b, c] = surface.triangles.subarray(t, t + 3);
    const depth = depthInside(place, 3 * a, 3 * b, 3 * c, x, y);
    if (depth > front) {
      front = depth;
      best = t;
    }
  }
  return best;
}

// Depth of a triangle under (x, y), by its barycentric coordinates there; -Infinity outside.
function depthInside(place, a, b, c, x, y) {
  const [bx, by] = [place[b] - place[a], place[b + 1] - place[a + 1]];
  const [cx, cy] = [place[c] - place[a], place[c + 1] - place[a + 1]];
  const [px, py] = [x - place[a], y - place[a + 1]];
  const area = bx * cy - cx * by;
  const second = (px * cy - cx * py) / area;
  const third = (bx * py - px * by) / area;
  if (!(second >= 0 && third >= 0 && second + third <= 1)) return -Infinity;
  return (1 - second - third) * place[a + 2] + second * place[b + 2] + third * place[c + 2];
}

function nearestPoint(place, points, x, y, farthest) {
  let best = -1;
  let least = farthest;
  for (const point of points) {
    const distance = Math.hypot(place[3 * point] - x, place[3 * point + 1] - y);
    if (distance <= least) {
      least = distance;
      best = point;
    }
  }
  return best;
}
