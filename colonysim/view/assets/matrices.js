// Just enough of linear algebra for one camera and one sun. Matrices are 4 x 4, column by column.

export const subtract = (a, b) => a.map((value, i) => value - b[i]);
export const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const unitVector = (a) => a.map((value) => value / Math.hypot(...a));

export function multiply(a, b) {
  const product = new Float32Array(16);
  for (let column = 0; column < 4; column++) {
    for (let row = 0; row < 4; row++) {
      for (let i = 0; i < 4; i++) product[4 * column + row] += a[4 * i + row] * b[4 * column + i];
    }
  }
  return product;
}

export function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

export const orthographic = (half, depth) => new Float32Array([1 / half, 0, 0, 0, 0, 1 / half, 0, 0, 0, 0, -1 / depth, 0, 0, 0, 0, 1]);

export function lookAt(eye, target, up = [0, 0, 1]) {
  const back = unitVector(subtract(eye, target));
  const right = unitVector(cross(up, back));
  const above = cross(back, right);
  return new Float32Array([
    right[0], above[0], back[0], 0, right[1], above[1], back[1], 0, right[2], above[2], back[2], 0,
    -dot(right, eye), -dot(above, eye), -dot(back, eye), 1,
  ]);
}

/** A rotation as x, y, z, w: first roll about x, then pitch about y, then yaw about z. */
export function quaternion(roll, pitch, yaw) {
  const [sr, sp, sy] = [roll, pitch, yaw].map((angle) => Math.sin(angle / 2));
  const [cr, cp, cy] = [roll, pitch, yaw].map((angle) => Math.cos(angle / 2));
  return [sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy];
}

/** A vector turned by a quaternion. */
export function turn([x, y, z, w], v) {
  const u = [x, y, z];
  const t = cross(u, v).map((value) => 2 * value);
  const s = cross(u, t);
  return v.map((value, i) => value + w * t[i] + s[i]);
}
