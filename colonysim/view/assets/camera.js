// Looking at a plane: pan and zoom by mouse, touch and keys. y points north, as in the scenarios.

export class Camera {
  constructor(bounds) {
    this.bounds = bounds; // west, south, east, north
    this.width = this.height = 1;
    this.version = 0;
    this.fit();
  }

  resize(width, height) {
    const fitted = this.fitted;
    this.width = width;
    this.height = height;
    if (fitted) this.fit();
    this.version++;
  }

  fit() {
    const [west, south, east, north] = this.bounds;
    this.x = (west + east) / 2;
    this.y = (south + north) / 2;
    this.scale = Math.min(this.width / (east - west), this.height / (north - south));
    this.fitted = true;
    this.version++;
  }

  /** Zooms about a point of the screen. */
  zoom(factor, px = this.width / 2, py = this.height / 2) {
    const [x, y] = this.toPlace(px, py);
    const least = 0.5 * Math.min(this.width / (this.bounds[2] - this.bounds[0]), this.height / (this.bounds[3] - this.bounds[1]));
    this.scale = Math.min(Math.max(this.scale * factor, least), 4000);
    this.x = x - (px - this.width / 2) / this.scale;
    this.y = y + (py - this.height / 2) / this.scale;
    this.fitted = false;
    this.version++;
  }

  drag(dx, dy) {
    this.x -= dx / this.scale;
    this.y += dy / this.scale;
    this.fitted = false;
    this.version++;
  }

  toPlace(px, py) {
    return [this.x + (px - this.width / 2) / this.scale, this.y - (py - this.height / 2) / this.scale];
  }

  screenX(x) { return (x - this.x) * this.scale + this.width / 2; }
  screenY(y) { return (this.y - y) * this.scale + this.height / 2; }
}

/** Tells what pointers do on an element: `drag(dx, dy, second)`, `zoom(factor, x, y)`, `click(x, y)`. */
export function watchPointers(element, { drag, zoom, click }) {
  const held = new Map();
  let moved = 0;
  const middle = () => {
    const all = [...held.values()];
    const [a, b] = [all[0], all[1] ?? all[0]];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, apart: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  const at = (event) => {
    const { left, top } = element.getBoundingClientRect();
    return { x: event.clientX - left, y: event.clientY - top };
  };
  element.addEventListener("pointerdown", (event) => {
    if (held.size === 0) moved = 0;
    held.set(event.pointerId, at(event));
    element.setPointerCapture(event.pointerId);
  });
  element.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const before = middle();
    held.set(event.pointerId, at(event));
    const now = middle();
    moved += Math.abs(now.x - before.x) + Math.abs(now.y - before.y);
    if (moved > 4) drag(now.x - before.x, now.y - before.y, held.size > 1 || event.shiftKey || (event.buttons & 2) > 0);
    if (held.size > 1 && before.apart > 0) zoom(now.apart / before.apart, now.x, now.y);
  });
  const release = (event) => {
    const was = held.get(event.pointerId);
    held.delete(event.pointerId);
    if (was && event.type === "pointerup" && held.size === 0 && moved <= 4) click(was.x, was.y);
    if (held.size > 0) moved = 5; // what is left of two fingers is no click
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    const { x, y } = at(event);
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), x, y);
  }, { passive: false });
}
