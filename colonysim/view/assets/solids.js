// Draws many cuboids and cylinders in one go each, with one sun and its shadows. WebGL 2 and nothing else.

import { lookAt, multiply, orthographic } from "./matrices.js";

const FLOATS = 14; // centre 3, half sizes 3, rotation 4, colour 3, width of the edges drawn 1
export const GROUND = -1; // for that width: a slab of the ground, which is warm where there is heat
const SHADOW_SIZE = 2048;

const PLACE = `#version 300 es
layout(location = 0) in vec3 corner;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 centre;
layout(location = 3) in vec3 halfSize;
layout(location = 4) in vec4 rotation;
layout(location = 5) in vec4 paint;
vec3 turned(vec3 v) { return v + 2.0 * cross(rotation.xyz, cross(rotation.xyz, v) + rotation.w * v); }
vec3 placed() { return centre + turned(corner * halfSize); }
`;
const SHADOW_VERTEX = `${PLACE}
uniform mat4 sunView;
void main() { gl_Position = sunView * vec4(placed(), 1.0); }`;
const SHADOW_FRAGMENT = `#version 300 es
precision mediump float;
void main() {}`;
const VERTEX = `${PLACE}
uniform mat4 view;
uniform mat4 sunView;
uniform vec3 eye;
uniform vec4 heatPlace; // west, north, one over its width and its height
out vec3 upward;
out vec2 heatAt;
out vec3 toEye;
out vec3 within;
out vec4 sunPlace;
flat out vec3 size;
flat out vec4 colour;
void main() {
  vec3 at = placed();
  upward = turned(normal);
  within = corner * halfSize;
  size = halfSize;
  colour = paint;
  sunPlace = sunView * vec4(at + 0.02 * upward, 1.0);
  toEye = eye - at;
  heatAt = vec2(at.x - heatPlace.x, heatPlace.y - at.y) * heatPlace.zw;
  gl_Position = view * vec4(at, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
uniform sampler2DShadow shadow;
uniform sampler2D heat;
uniform vec3 sun;
in vec3 upward;
in vec2 heatAt;
in vec3 toEye;
in vec3 within;
in vec4 sunPlace;
flat in vec3 size;
flat in vec4 colour;
out vec4 shown;
void main() {
  vec3 n = normalize(upward);
  // A side that is seen edge-on has no depth to speak of and would shine through the slab before it.
  if (colour.a < 0.0 && abs(n.z) < 0.5 && abs(dot(n, normalize(toEye))) < 0.08) discard;
  // Where two slabs of the ground meet, the rim of the sides that they share may shine through: it looks like their top.
  bool rim = colour.a < 0.0 && size.z - within.z < 0.06;
  if (rim) n = vec3(0.0, 0.0, 1.0);
  vec3 base = colour.rgb;
  if (colour.a < 0.0 && n.z > 0.6) {
    vec4 warm = texture(heat, heatAt); // already multiplied by its opacity
    base = base * (1.0 - warm.a) + warm.rgb;
  }
  vec3 at = sunPlace.xyz * 0.5 + 0.5;
  float lit = 0.0;
  for (int i = -2; i <= 2; i++) for (int j = -2; j <= 2; j++)
    lit += texture(shadow, vec3(at.xy + vec2(i, j) / ${SHADOW_SIZE}.0, at.z - 0.0014)) / 25.0;
  if ((rim && upward.z < 0.5) || any(lessThan(at, vec3(0.0))) || any(greaterThan(at, vec3(1.0)))) lit = 1.0;
  float light = 0.45 + 0.08 * n.z + 0.58 * lit * max(dot(n, sun), 0.0);
  if (colour.a > 0.0) {
    vec3 off = size - abs(within);
    float least = min(off.x, min(off.y, off.z));
    float edge = off.x + off.y + off.z - least - max(off.x, max(off.y, off.z));
    light *= mix(0.62, 1.0, smoothstep(0.5 * colour.a, colour.a, edge));
  }
  shown = vec4(base * light, 1.0);
}`;

export class Solids {
  /** Throws where there is no WebGL 2. */
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", { antialias: true });
    if (!gl) throw new Error("no WebGL 2");
    this.gl = gl;
    this.program = link(gl, VERTEX, FRAGMENT);
    this.shadowProgram = link(gl, SHADOW_VERTEX, SHADOW_FRAGMENT);
    this.shapes = { cuboid: this.shape(cuboid()), cylinder: this.shape(cylinder(24)) };
    this.shadow = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.shadow);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE, 0, gl.DEPTH_COMPONENT, gl.UNSIGNED_INT, null);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    this.depths = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.depths);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.shadow, 0);
    this.heat = gl.createTexture();
    this.warm(new ImageData(1, 1), [0, 0, 1, 1]);
  }

  /** Takes the heat of the ground: a picture seen from above, and its west, south, east and north in metres. */
  warm(image, [west, south, east, north]) {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.heat);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, true);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    for (const wrap of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, wrap, gl.CLAMP_TO_EDGE);
    this.heatPlace = [west, north, 1 / (east - west), 1 / (north - south)];
  }

  shape(vertices) {
    const { gl } = this;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
    attribute(gl, 0, 3, 24, 0);
    attribute(gl, 1, 3, 24, 12);
    const instances = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, instances);
    [3, 3, 4, 4].reduce((offset, count, i) => {
      attribute(gl, 2 + i, count, 4 * FLOATS, offset);
      gl.vertexAttribDivisor(2 + i, 1);
      return offset + 4 * count;
    }, 0);
    return { array, instances, vertices: vertices.length / 6, count: 0 };
  }

  /** Takes the bodies to draw: lists of [centre, half sizes, rotation, colour (0 to 1), width of edges]. */
  load(bodies) {
    const { gl } = this;
    for (const [name, shape] of Object.entries(this.shapes)) {
      gl.bindBuffer(gl.ARRAY_BUFFER, shape.instances);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array((bodies[name] ?? []).flat(2)), gl.DYNAMIC_DRAW);
      shape.count = bodies[name]?.length ?? 0;
    }
  }

  draw(view, { eye, centre, radius, sun, sky }) {
    const { gl } = this;
    const sunEye = centre.map((value, i) => value + 2 * radius * sun[i]);
    const sunView = multiply(orthographic(radius, 2 * radius), lookAt(sunEye, centre));
    sunView[14] -= 1; // from before the eye to behind the place
    gl.enable(gl.DEPTH_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.depths);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.shadowProgram);
    this.all(this.shadowProgram, { sunView });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight);
    gl.clearColor(...sky, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(this.program);
    ["shadow", "heat"].forEach((name, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, this[name]);
      gl.uniform1i(gl.getUniformLocation(this.program, name), unit);
    });
    gl.uniform4fv(gl.getUniformLocation(this.program, "heatPlace"), this.heatPlace);
    gl.uniform3fv(gl.getUniformLocation(this.program, "sun"), sun);
    gl.uniform3fv(gl.getUniformLocation(this.program, "eye"), eye);
    this.all(this.program, { view, sunView });
  }

  all(program, matrices) {
    const { gl } = this;
    for (const [name, matrix] of Object.entries(matrices)) gl.uniformMatrix4fv(gl.getUniformLocation(program, name), false, matrix);
    for (const { array, vertices, count } of Object.values(this.shapes)) {
      gl.bindVertexArray(array);
      if (count) gl.drawArraysInstanced(gl.TRIANGLES, 0, vertices, count);
    }
  }
}

function attribute(gl, place, count, stride, offset) {
  gl.enableVertexAttribArray(place);
  gl.vertexAttribPointer(place, count, gl.FLOAT, false, stride, offset);
}

function link(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program) || "shader");
  return program;
}

/** Corners and normals of the cube from -1 to 1, as triangles. */
function cuboid() {
  const vertices = [];
  for (const axis of [0, 1, 2]) {
    for (const side of [-1, 1]) {
      const normal = [0, 0, 0];
      normal[axis] = side;
      for (const [u, v] of [[-1, -1], [1, -1], [1, 1], [-1, -1], [1, 1], [-1, 1]]) {
        const corner = [0, 0, 0];
        [corner[axis], corner[(axis + 1) % 3], corner[(axis + 2) % 3]] = [side, u, v];
        vertices.push(...corner, ...normal);
      }
    }
  }
  return vertices;
}

/** The same of a cylinder of radius 1 about the y axis. */
function cylinder(sides) {
  const vertices = [];
  const around = (i) => [Math.cos((2 * Math.PI * i) / sides), Math.sin((2 * Math.PI * i) / sides)];
  for (let i = 0; i < sides; i++) {
    const [a, b] = [around(i), around(i + 1)];
    for (const [p, y] of [[a, -1], [b, -1], [b, 1], [a, -1], [b, 1], [a, 1]]) vertices.push(p[0], y, p[1], p[0], 0, p[1]);
    for (const y of [-1, 1]) vertices.push(0, y, 0, 0, y, 0, a[0], y, a[1], 0, y, 0, b[0], y, b[1], 0, y, 0);
  }
  return vertices;
}
