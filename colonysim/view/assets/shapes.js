// The pens of the map: signs that are drawn at a place of the screen.

export function disc(pen, x, y, radius, fill, line, width = 1) {
  pen.beginPath();
  pen.arc(x, y, radius, 0, 2 * Math.PI);
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  if (line) { pen.strokeStyle = line; pen.lineWidth = width; pen.stroke(); }
}

export function square(pen, x, y, half, fill, line, width = 1) {
  pen.beginPath();
  pen.roundRect(x - half, y - half, 2 * half, 2 * half, Math.min(half * 0.3, 4));
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  if (line) { pen.strokeStyle = line; pen.lineWidth = width; pen.stroke(); }
}

export function diamond(pen, x, y, half, fill, line, width = 1) {
  pen.beginPath();
  pen.moveTo(x, y - half);
  pen.lineTo(x + half, y);
  pen.lineTo(x, y + half);
  pen.lineTo(x - half, y);
  pen.closePath();
  if (fill) { pen.fillStyle = fill; pen.fill(); }
  if (line) { pen.strokeStyle = line; pen.lineWidth = width; pen.stroke(); }
}

export function segment(pen, x0, y0, x1, y1) {
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
}

export function word(pen, text, x, y, size, fill, halo, weight = 600) {
  pen.font = `${weight} ${size}px system-ui, sans-serif`;
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  if (halo) {
    pen.strokeStyle = halo;
    pen.lineWidth = Math.min(3, 0.25 * size);
    pen.lineJoin = "round";
    pen.strokeText(text, x, y);
  }
  pen.fillStyle = fill;
  pen.fillText(text, x, y);
}

/**
 * The labels of an agent and of a box, the same on the map and in 3D: a disc with A and a square with B before the
 * number, so that neither is ever read as a node's number, which stands alone and has no ground of its own.
 */
export const agentLabel = (agent) => `A${agent}`;
export const boxLabel = (box) => `B${box}`;

/** Writes a label into a sign of this radius, as large as it has room for; not at all if it could not be read. */
export function writeSign(pen, text, x, y, radius, fill) {
  const size = Math.min(0.86 * radius, (2.75 * radius) / text.length, 13);
  if (size >= 6.5) word(pen, text, x, y + 0.04 * size, size, fill, null, 700);
}

/** A picture that is kept until its key, its size or the sharpness of the screen changes. */
export class Picture {
  /** Returns its canvas, painted with `paint(pen)` if need be; the pen's unit is a CSS pixel. */
  of(key, { width, height }, paint) {
    const ratio = window.devicePixelRatio || 1;
    const state = [key, width, height, ratio].join();
    if (state === this.state) return this.canvas;
    this.state = state;
    const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
    if (this.canvas?.width !== w || this.canvas.height !== h) this.canvas = new OffscreenCanvas(w, h);
    const pen = this.canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, height);
    paint(pen);
    return this.canvas;
  }
}

/** Draws the same disc many times: painted once for each colour, then copied. */
export class Stamp {
  constructor(radius, line, width, ratio = window.devicePixelRatio || 1) {
    Object.assign(this, { radius, line, width, ratio });
    this.size = 2 * Math.ceil(radius + width);
    this.made = new Map();
  }

  draw(pen, x, y, fill) {
    if (!this.made.has(fill)) {
      const copy = new OffscreenCanvas(this.size * this.ratio, this.size * this.ratio);
      const own = copy.getContext("2d");
      own.scale(this.ratio, this.ratio);
      disc(own, this.size / 2, this.size / 2, this.radius, fill, this.line, this.width);
      this.made.set(fill, copy);
    }
    pen.drawImage(this.made.get(fill), x - this.size / 2, y - this.size / 2, this.size, this.size);
  }
}

/** A canvas as sharp as the screen: sizes it to its box and returns its pen, whose unit is a CSS pixel. */
export function sharpen(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const w = Math.max(1, Math.round(width * ratio)), h = Math.max(1, Math.round(height * ratio));
  if (canvas.width !== w || canvas.height !== h) {
    canvas.width = w;
    canvas.height = h;
  }
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { pen, width, height, ratio };
}
