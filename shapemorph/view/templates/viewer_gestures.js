// Turning, shifting and zooming with mouse, fingers and keys.

const CLICK = 4; // px that a pointer may move in a click

function listen(canvas, camera, { redraw, pick }) {
  const pointers = new Map();
  let moved = 0;

  const local = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, local(event));
    if (pointers.size === 1) moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!pointers.has(event.pointerId)) return;
    const before = pointers.get(event.pointerId);
    const now = local(event);
    const step = [now[0] - before[0], now[1] - before[1]];
    moved += Math.hypot(...step);
    if (pointers.size > 1) {
      pinch(camera, [...pointers.values()], before, now);
    } else if (event.shiftKey || event.buttons & 6) {
      shift(camera, step);
    } else if (moved > CLICK) {
      turn(camera, step[0] / 150, step[1] / 150);
    }
    pointers.set(event.pointerId, now);
    redraw();
  });
  const end = (event) => {
    const wasClick = event.type === "pointerup" && pointers.size === 1 && moved <= CLICK;
    pointers.delete(event.pointerId);
    if (wasClick && event.button === 0) pick(...local(event));
  };
  canvas.addEventListener("pointerup", end);
  canvas.addEventListener("pointercancel", end);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const lines = event.deltaMode === 1 ? 16 : 1;
      zoom(camera, Math.exp(-0.0015 * lines * event.deltaY), local(event));
      redraw();
    },
    { passive: false },
  );
  canvas.addEventListener("keydown", (event) => {
    const centre = [camera.width / 2, camera.height / 2];
    const action = {
      ArrowLeft: () => turn(camera, -0.1, 0),
      ArrowRight: () => turn(camera, 0.1, 0),
      ArrowUp: () => turn(camera, 0, -0.1),
      ArrowDown: () => turn(camera, 0, 0.1),
      "+": () => zoom(camera, 1.2, centre),
      "-": () => zoom(camera, 1 / 1.2, centre),
      Enter: () => pick(...centre),
    }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
    redraw();
  });
}

// The front of the shape follows the pointer: right about the vertical, down about the level axis.
function turn(camera, right, down) {
  const [x, y, z] = camera.turn;
  const [c, s] = [Math.cos(right), Math.sin(right)];
  const across = x.map((part, k) => c * part + s * z[k]);
  const depth = x.map((part, k) => c * z[k] - s * part);
  const [d, t] = [Math.cos(down), Math.sin(down)];
  const up = y.map((part, k) => d * part - t * depth[k]);
  const toward = unit(y.map((part, k) => d * depth[k] + t * part));
  const level = unit(cross(up, toward));
  camera.turn = [level, cross(toward, level), toward];
}

const unit = (a) => a.map((part) => part / Math.hypot(...a));

function shift(camera, step) {
  camera.shift = camera.shift.map((part, k) => part + step[k]);
}

function zoom(camera, factor, about) {
  const centre = [camera.width / 2, camera.height / 2];
  camera.scale *= factor;
  camera.shift = camera.shift.map((part, k) => {
    const from = about[k] - centre[k];
    return from + factor * (part - from);
  });
}

// Two fingers: one stays, the other went from `before` to `now`.
function pinch(camera, places, before, now) {
  const other = places.find((place) => place !== before) || before;
  const length = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]) || 1;
  zoom(camera, length(now) / length(before), other);
  shift(camera, [(now[0] - before[0]) / 2, (now[1] - before[1]) / 2]);
}
