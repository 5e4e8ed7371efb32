// Draws the same without WebGL: triangles from back to front.

function canvasPainter(canvas, surface, look) {
  const context = canvas.getContext("2d");
  const many = surface.triangles.length / 3;
  const depth = new Float32Array(many);
  const order = Uint32Array.from({ length: many }, (_, index) => index);
  const place = new Float32Array(3 * surface.count);
  let colours = null;

  function fill(triangle) {
    const [a, b, c] = surface.triangles.subarray(3 * triangle, 3 * triangle + 3);
    const value = (colours.values[a] + colours.values[b] + colours.values[c]) / 3;
    const at = 3 * tableStep(value, colours.range);
    const colour = Number.isFinite(value)
      ? colours.table.slice(at, at + 3)
      : look.bare.map((part) => 255 * part);
    const ab = minus(place.subarray(3 * b), place.subarray(3 * a));
    const ac = minus(place.subarray(3 * c), place.subarray(3 * a));
    const normal = cross(ab, ac);
    const light = 0.75 + (0.25 * Math.abs(normal[2])) / (Math.hypot(...normal) || 1);
    const style = `rgb(${colour.map((part) => Math.round(part * light)).join()})`;
    context.fillStyle = context.strokeStyle = style;
    context.beginPath();
    for (const corner of [a, b, c]) context.lineTo(place[3 * corner], place[3 * corner + 1]);
    context.closePath();
    context.fill();
    context.stroke(); // else hairlines of the ground show between triangles
  }

  return {
    kind: "canvas",
    colour(values, table, range) {
      colours = { values, table, range };
    },
    draw(camera) {
      context.setTransform(camera.ratio, 0, 0, camera.ratio, 0, 0);
      context.clearRect(0, 0, camera.width, camera.height);
      context.lineWidth = 0.5;
      projectAll(surface, camera, place);
      for (let t = 0; t < many; t++) {
        const corners = surface.triangles.subarray(3 * t, 3 * t + 3);
        depth[t] = corners.reduce((sum, corner) => sum + place[3 * corner + 2], 0);
      }
      order.sort((a, b) => depth[a] - depth[b]);
      order.forEach(fill);
      if (camera.state !== 0) return;
      for (let n = surface.shown; n < surface.count; n++) {
        const at = 3 * surface.status[n];
        context.fillStyle = `rgb(${look.statusTable.slice(at, at + 3).join()})`;
        context.fillRect(place[3 * n] - 2.5, place[3 * n + 1] - 2.5, 5, 5);
      }
    },
  };
}

// Which of the 256 colours of a table a value has.
function tableStep(value, [low, high]) {
  return Math.round(255 * Math.min(1, Math.max(0, (value - low) / (high - low))));
}

// Screen x, y in CSS px from the upper left, and depth in mm toward the viewer.
function projectAll(surface, camera, place) {
  const position = new Float64Array(3);
  for (let n = 0; n < surface.count; n++) {
    positionOf(surface, n, n < surface.shown ? camera.state : 0, position);
    place.set(projected(camera, position), 3 * n);
  }
}

function projected(camera, position) {
  const [x, y, z] = camera.turn.map((row) =>
    row.reduce((sum, part, k) => sum + part * (position[k] - camera.middle[k]), 0),
  );
  return [
    camera.width / 2 + camera.shift[0] + camera.scale * x,
    camera.height / 2 + camera.shift[1] - camera.scale * y,
    z,
  ];
}
