// Draws the surface with WebGL. Returns null where there is none, or it does not do.

const VERTEX_SHADER = `
attribute vec3 reference, displacement, before, after;
attribute vec2 value;
uniform mat3 turn;
uniform vec3 middle, scale;
uniform vec2 shift;
uniform float state, dot, least;
varying vec2 seen;
varying float light;
void main() {
  vec3 place = turn * (reference + state * displacement - middle) * scale;
  vec3 normal = turn * mix(before, after, state);
  light = max(least, abs(normal.z) / max(length(normal), 1e-6));
  seen = value;
  gl_PointSize = dot;
  gl_Position = vec4(place.xy + shift, -place.z, 1.0);
}`;

// A value of which the second number is not 1 is missing.
const FRAGMENT_SHADER = `
precision highp float;
uniform sampler2D map;
uniform vec2 range;
uniform vec3 bare;
varying vec2 seen;
varying float light;
void main() {
  float share = clamp((seen.x - range.x) / (range.y - range.x), 0.0, 1.0);
  vec3 colour = texture2D(map, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  colour = seen.y < 0.999 ? bare : colour;
  gl_FragColor = vec4(colour * (0.75 + 0.25 * light), 1.0);
}`;

function webglPainter(canvas, surface, look) {
  const options = { antialias: true };
  const gl = canvas.getContext("webgl2", options) || canvas.getContext("webgl", options);
  if (!gl || !(gl.createVertexArray || gl.getExtension("OES_element_index_uint"))) return null;
  const program = linkProgram(gl);
  if (!program) return null;
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  gl.clearColor(1, 1, 1, 1);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const shown = 3 * surface.shown;
  const lost = surface.count - surface.shown;
  const nothing = buffer(gl, new Float32Array(3 * lost));
  const buffers = {
    surface: {
      reference: buffer(gl, surface.reference.subarray(0, shown)),
      displacement: buffer(gl, surface.displacement.subarray(0, shown)),
      before: buffer(gl, surface.normals[0]),
      after: buffer(gl, surface.normals[1]),
      value: buffer(gl, new Float32Array(2 * surface.shown)),
    },
    lost: {
      reference: buffer(gl, surface.reference.subarray(shown)),
      displacement: nothing,
      before: nothing,
      after: nothing,
      value: buffer(gl, pairs(surface.status.subarray(surface.shown))),
    },
  };
  const indices = buffer(gl, surface.triangles, gl.ELEMENT_ARRAY_BUFFER);
  const maps = { surface: texture(gl), lost: texture(gl) };
  fillTexture(gl, maps.lost, look.statusTable);
  gl.uniform3fv(uniform("bare"), look.bare);

  function bind(name, range, least) {
    for (const [attribute, stored] of Object.entries(buffers[name])) {
      const place = gl.getAttribLocation(program, attribute);
      gl.bindBuffer(gl.ARRAY_BUFFER, stored);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, attribute === "value" ? 2 : 3, gl.FLOAT, false, 0, 0);
    }
    gl.bindTexture(gl.TEXTURE_2D, maps[name]);
    gl.uniform2fv(uniform("range"), range);
    gl.uniform1f(uniform("least"), least); // light on what looks away
  }

  let colours = { range: [0, 1] };
  return {
    kind: "webgl",
    colour(values, table, range) {
      colours = { range };
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers.surface.value);
      gl.bufferData(gl.ARRAY_BUFFER, pairs(values.subarray(0, surface.shown)), gl.STATIC_DRAW);
      fillTexture(gl, maps.surface, table);
    },
    draw(camera) {
      const { width, height, scale, shift } = camera;
      gl.viewport(0, 0, canvas.width, canvas.height);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      gl.uniformMatrix3fv(uniform("turn"), false, columns(camera.turn));
      gl.uniform3fv(uniform("middle"), camera.middle);
      gl.uniform3f(uniform("scale"), (2 * scale) / width, (2 * scale) / height, 0.5 / camera.radius);
      gl.uniform2f(uniform("shift"), (2 * shift[0]) / width, (-2 * shift[1]) / height);
      gl.uniform1f(uniform("state"), camera.state);
      gl.uniform1f(uniform("dot"), 5 * camera.ratio);
      bind("surface", colours.range, 0);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
      gl.drawElements(gl.TRIANGLES, surface.triangles.length, gl.UNSIGNED_INT, 0);
      if (lost && camera.state === 0) {
        bind("lost", [0, 255], 1);
        gl.drawArrays(gl.POINTS, 0, lost);
      }
    },
  };
}

function linkProgram(gl) {
  const program = gl.createProgram();
  for (const [kind, source] of [
    [gl.VERTEX_SHADER, VERTEX_SHADER],
    [gl.FRAGMENT_SHADER, FRAGMENT_SHADER],
  ]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return gl.getProgramParameter(program, gl.LINK_STATUS) ? program : null;
}

function buffer(gl, data, target = gl.ARRAY_BUFFER) {
  const stored = gl.createBuffer();
  gl.bindBuffer(target, stored);
  gl.bufferData(target, data, gl.STATIC_DRAW);
  return stored;
}

function texture(gl) {
  const stored = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, stored);
  for (const side of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) {
    gl.texParameteri(gl.TEXTURE_2D, side, gl.NEAREST);
  }
  for (const side of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) {
    gl.texParameteri(gl.TEXTURE_2D, side, gl.CLAMP_TO_EDGE);
  }
  return stored;
}

// A table of 256 colours.
function fillTexture(gl, stored, table) {
  gl.bindTexture(gl.TEXTURE_2D, stored);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array(table));
}

// Each value, and whether it is there.
function pairs(values) {
  const both = new Float32Array(2 * values.length);
  values.forEach((value, n) => {
    const known = Number.isFinite(value);
    both[2 * n] = known ? value : 0;
    both[2 * n + 1] = known ? 1 : 0;
  });
  return both;
}

const columns = (rows) => [0, 1, 2].flatMap((column) => rows.map((row) => row[column]));
