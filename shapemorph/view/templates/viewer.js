// The interactive view: controls, camera, values of a point.

const STATUS = "status";

function startViewer(about, text) {
  const find = (name) => document.getElementById("viewer-" + name);
  const surface = unpackSurface(about, text);
  const look = {
    bare: rgb(about.bare).map((part) => part / 255),
    statusTable: paddedTable(about.statuses.flatMap((status) => rgb(status.colour))),
  };
  let canvas = find("canvas");
  let painter = location.hash === "#canvas" ? null : webglPainter(canvas, surface, look);
  if (!painter) {
    const plain = canvas.cloneNode(); // one that was asked for WebGL gives nothing else
    canvas.replaceWith(plain);
    canvas = plain;
    painter = canvasPainter(canvas, surface, look);
  }
  canvas.dataset.painter = painter.kind;

  const camera = { turn: about.view, shift: [0, 0], scale: 1, state: 1, ...extent(surface) };
  let field = about.fields.find((one) => one.key === "E1") || about.fields[0];
  let picked = -1;
  let waiting = false;

  function redraw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      painter.draw(camera);
      showMark(find("mark"), surface, camera, picked);
      showScaleBar(find("scale"), camera);
    });
  }

  function fit() {
    const place = new Float32Array(3 * surface.count);
    camera.scale = 1;
    camera.shift = [0, 0];
    projectAll(surface, camera, place);
    const low = [Infinity, Infinity];
    const high = [-Infinity, -Infinity];
    for (let n = 0; n < 3 * surface.shown; n++) {
      if (n % 3 === 2) continue;
      low[n % 3] = Math.min(low[n % 3], place[n]);
      high[n % 3] = Math.max(high[n % 3], place[n]);
    }
    const across = [0, 1].map((k) => Math.max(high[k] - low[k], 1e-9));
    camera.scale = 0.94 * Math.min(camera.width / across[0], (camera.height - 40) / across[1]);
    const centre = [camera.width / 2, camera.height / 2];
    camera.shift = [0, 1].map((k) => camera.scale * (centre[k] - (low[k] + high[k]) / 2));
    camera.shift[1] -= 16; // room for the scale bar
    redraw();
  }

  function resize() {
    const before = camera.width;
    camera.width = canvas.clientWidth;
    camera.height = canvas.clientHeight;
    camera.ratio = Math.min(devicePixelRatio || 1, 2);
    canvas.width = Math.round(camera.width * camera.ratio);
    canvas.height = Math.round(camera.height * camera.ratio);
    if (!before) return fit();
    const change = camera.width / before;
    camera.scale *= change;
    camera.shift = camera.shift.map((part) => part * change);
    redraw();
  }

  function colour(range) {
    const isStatus = field === STATUS;
    find("range").hidden = isStatus;
    if (isStatus) {
      painter.colour(new Float32Array(surface.count), look.statusTable, [0, 255]);
    } else {
      painter.colour(fieldValues(surface, field), about.maps[field.map], range);
      find("low").value = short(range[0]);
      find("high").value = short(range[1]);
    }
    showBar(find("bar"), about, field, range);
    redraw();
  }

  function setState(state) {
    camera.state = state;
    find("state").value = state;
    redraw();
  }

  for (const one of about.fields) find("field").add(new Option(`${one.symbol}  ${one.name}`, one.key));
  find("field").add(new Option("Status of each point", STATUS));
  find("field").value = field.key;
  find("field").addEventListener("change", (event) => {
    field = about.fields.find((one) => one.key === event.target.value) || STATUS;
    if (field === STATUS) setState(0); // a lost point has a place on the reference alone
    colour(field.range);
  });
  for (const end of ["low", "high"]) {
    find(end).addEventListener("change", () => {
      const range = ["low", "high"].map((name) => Number.parseFloat(find(name).value));
      if (range[0] < range[1]) colour(range);
    });
  }
  find("auto").addEventListener("click", () => colour(field.range));
  find("state").addEventListener("input", (event) => setState(Number(event.target.value)));
  find("reset").addEventListener("click", () => {
    camera.turn = about.view;
    fit();
  });
  const pick = (x, y) => {
    picked = pickPoint(surface, camera, x, y);
    showValues(find("values"), about, surface, picked);
    redraw();
  };
  listen(canvas, camera, { redraw, pick });
  new ResizeObserver(resize).observe(canvas);
  resize();
  colour(field.range);
  // For scripts: where a row of measurement.csv is drawn, in px of the window.
  globalThis.shapemorphViewer = {
    painter: painter.kind,
    place(row) {
      const point = surface.row.indexOf(row);
      const box = canvas.getBoundingClientRect();
      const state = point < surface.shown ? camera.state : 0;
      const [x, y] = projected(camera, positionOf(surface, point, state, [0, 0, 0]));
      return [box.left + x, box.top + y];
    },
  };
}

// Middle of both shapes and a radius about it, mm.
function extent(surface) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  const position = new Float64Array(3);
  for (const state of [0, 1]) {
    for (let n = 0; n < surface.shown; n++) {
      positionOf(surface, n, state, position);
      for (let k = 0; k < 3; k++) {
        low[k] = Math.min(low[k], position[k]);
        high[k] = Math.max(high[k], position[k]);
      }
    }
  }
  const middle = low.map((value, k) => (value + high[k]) / 2);
  return { middle, radius: Math.hypot(...minus(high, low)) / 2 || 1 };
}

const rgb = (hex) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16));
const paddedTable = (table) => [...table, ...Array(768 - table.length).fill(0)];
const short = (value) => String(Number(value.toPrecision(4)));
