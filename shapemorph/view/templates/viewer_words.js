// What stands around the picture: colour bar, scale bar, values of a point.

function element(name, text, parent) {
  const made = document.createElement(name);
  made.textContent = text;
  if (parent) parent.append(made);
  return made;
}

function showBar(bar, about, field, range) {
  bar.replaceChildren();
  if (field === STATUS) {
    element("strong", "Status of each point", bar);
    for (const status of about.statuses.filter((one) => one.occurs)) {
      const item = element("span", status.word, bar);
      item.className = "key";
      item.style.setProperty("--colour", status.colour);
    }
    return;
  }
  const unit = field.unit ? `, ${field.unit}` : ", no unit";
  element("strong", `${field.name} ${field.symbol}${unit}`, bar);
  const table = about.maps[field.map];
  const stops = Array.from({ length: 33 }, (_, k) => {
    const at = 3 * Math.round((255 * k) / 32);
    return `rgb(${table.slice(at, at + 3).join()})`;
  });
  element("div", "", bar).style.background = `linear-gradient(to right, ${stops.join()})`;
  const ticks = element("ol", "", bar);
  for (const value of roundTicks(range)) {
    const share = (value - range[0]) / (range[1] - range[0]);
    element("li", short(value), ticks).style.left = `${100 * share}%`;
  }
  element("small", `${field.note} Grey: no value.`, bar);
}

// Multiples of a round step within a range, about six of them.
function roundTicks([low, high]) {
  const step = roundLength((high - low) / 4);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) {
    ticks.push(k * step);
  }
  return ticks;
}

// Largest of 1, 2 or 5 times a power of ten that is not above `longest`.
function roundLength(longest) {
  const power = 10 ** Math.floor(Math.log10(longest));
  return power * [5, 2, 1].find((step) => step * power <= longest * (1 + 1e-9));
}

// A bar of a round length, at most a quarter of the width.
function showScaleBar(bar, camera) {
  const length = roundLength((0.25 * camera.width) / camera.scale);
  bar.style.width = `${length * camera.scale}px`;
  bar.textContent = `${short(length)} mm`;
}

function showMark(mark, surface, camera, point) {
  const placed = point >= 0 && (point < surface.shown || camera.state === 0);
  mark.hidden = !placed;
  if (!placed) return;
  const [x, y] = projected(camera, positionOf(surface, point, camera.state, [0, 0, 0]));
  mark.style.left = `${x}px`;
  mark.style.top = `${y}px`;
}

function showValues(box, about, surface, point) {
  box.replaceChildren();
  if (point < 0) {
    element("p", "No point there.", box);
    return;
  }
  const numbers = (array, k) => Array.from(array.subarray(k * point, k * point + k), withDash);
  const moved = Array.from(positionOf(surface, point, 1, new Float64Array(3)));
  const rows = [
    ["Row of measurement.csv, from 0", String(surface.row[point])],
    ["Status", about.statuses[surface.status[point]].name],
    ["Reference position x, y, z, mm", numbers(surface.reference, 3).join(", ")],
    ["Deformed position, aligned, mm", moved.map(withDash).join(", ")],
    ["Displacement u, v, w, mm", numbers(surface.displacement, 3).join(", ")],
  ];
  for (const field of about.fields.filter((one) => !one.key.startsWith("displacement_"))) {
    const unit = field.unit ? `, ${field.unit}` : "";
    rows.push([`${field.name} ${field.symbol}${unit}`, withDash(fieldValues(surface, field)[point])]);
  }
  const table = element("table", "", box);
  for (const [label, value] of rows) {
    const row = element("tr", "", table);
    element("th", label, row);
    element("td", value, row);
  }
}

const withDash = (value) => (Number.isFinite(value) ? short(value) : "–");
