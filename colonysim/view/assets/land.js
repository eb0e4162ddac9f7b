// The shape of the land: broad ways along the edges, filled where they enclose too little to be a lake, with rounded
// corners between them. Made once for a run, in units of the scenario, so that it is only scaled when it is drawn.

import { mix, style } from "./palette.js";
import { segment } from "./shapes.js";

const BROAD = 0.95; // width of a way, in mean lengths of an edge
const LAKE = 0.66; // radius of the largest disc within a ring of edges that is still land, in the same
const ROUND = 0.55; // how far from its corner a rounding begins, in the same
const NARROWEST = 0.3, WIDEST = 2.6; // angles between two edges whose corner is rounded, radians
const PIECE = 60; // lines that are drawn at once
const WATERLINES = [[10, 0.12], [5, 0.24]]; // beyond the coast: pixels, share of the coast's colour

/** Heights of the place: each node's bare ground (a hole's rim), from 0 (lowest) to 1. */
export function landShares(run) {
  const heights = Array.from(run.nodes.z);
  for (const [node, , rim] of run.holes) heights[node] = rim;
  let low = Infinity, high = -Infinity;
  for (const height of heights) {
    low = Math.min(low, height);
    high = Math.max(high, height);
  }
  return Float32Array.from(heights, (height) => (high > low ? (height - low) / (high - low) : 0.75));
}

/**
 * The edges that leave each node, against the clock: directed edge 2e leads from a[e] to b[e], 2e + 1 back.
 * `from` and `angle` belong to directed edges, `place` says where one stands among those of its node.
 */
export function fansOf({ nodes, edges }) {
  const { a, b } = edges;
  const fans = Array.from(nodes.x, () => []);
  const angle = new Float32Array(2 * a.length), place = new Int32Array(2 * a.length), from = new Int32Array(2 * a.length);
  for (let e = 0; e < a.length; e++) {
    const way = Math.atan2(nodes.y[b[e]] - nodes.y[a[e]], nodes.x[b[e]] - nodes.x[a[e]]);
    [angle[2 * e], angle[2 * e + 1]] = [way, way > 0 ? way - Math.PI : way + Math.PI];
    [from[2 * e], from[2 * e + 1]] = [a[e], b[e]];
    fans[a[e]].push(2 * e);
    fans[b[e]].push(2 * e + 1);
  }
  for (const fan of fans) {
    fan.sort((one, other) => angle[one] - angle[other]);
    fan.forEach((half, i) => { place[half] = i; });
  }
  return { fans, angle, place, from };
}

/** For each node the direction in which there is most room between its edges, radians: there its number stands. */
export function roomiest({ fans, angle }) {
  return Float32Array.from(fans, (fan) => {
    let best = -Math.PI / 4, most = -1;
    fan.forEach((half, i) => {
      const next = i + 1 < fan.length ? angle[fan[i + 1]] : angle[fan[0]] + 2 * Math.PI;
      const middle = (angle[half] + next) / 2;
      const room = next - angle[half] + 0.3 * Math.cos(middle + Math.PI / 4); // of equals the one at the lower right
      if (room > most) [best, most] = [middle, room];
    });
    return best;
  });
}

/** For each directed edge the number of the ring that it goes round against the clock; of each ring its edges. */
function ringsOf({ fans, place, from }) {
  const ring = new Int32Array(from.length).fill(-1);
  const rings = [];
  for (let start = 0; start < from.length; start++) {
    if (ring[start] >= 0) continue;
    const halves = [];
    for (let half = start; ring[half] < 0;) {
      ring[half] = rings.length;
      halves.push(half);
      const back = half ^ 1, fan = fans[from[back]];
      half = fan[(place[back] + fan.length - 1) % fan.length];
    }
    rings.push(halves);
  }
  return { ring, rings };
}

/** For each directed edge the height of the land that fills its ring, or -1 where there is room for a lake. */
function fillings({ nodes }, { from }, { ring, rings }, shares, length) {
  const filled = new Float32Array(from.length).fill(-1);
  for (const halves of rings) {
    let area = 0, around = 0, low = 1;
    for (const half of halves) {
      const [p, q] = [from[half], from[half ^ 1]];
      low = Math.min(low, shares[p]);
      area += 0.5 * (nodes.x[p] * nodes.y[q] - nodes.x[q] * nodes.y[p]);
      // A dead end within the ring is walked twice and encloses nothing.
      if (ring[half ^ 1] !== ring[half]) around += Math.hypot(nodes.x[q] - nodes.x[p], nodes.y[q] - nodes.y[p]);
    }
    if (area > 0 && around > 0 && (2 * area) / around < LAKE * length) for (const half of halves) filled[half] = low;
  }
  return filled;
}

/** Many broad lines in pieces: a browser takes far longer for all of them as one path, and those out of sight are left away. */
class Lines {
  constructor() { this.pieces = []; }

  add(x0, y0, x1, y1) {
    let piece = this.pieces.at(-1);
    if (!piece || piece.count === PIECE) {
      piece = { path: new Path2D(), count: 0, west: Infinity, south: Infinity, east: -Infinity, north: -Infinity };
      this.pieces.push(piece);
    }
    segment(piece.path, x0, y0, x1, y1);
    piece.count++;
    piece.west = Math.min(piece.west, x0, x1);
    piece.east = Math.max(piece.east, x0, x1);
    piece.south = Math.min(piece.south, y0, y1);
    piece.north = Math.max(piece.north, y0, y1);
  }

  stroke(pen, [west, south, east, north]) {
    for (const piece of this.pieces) {
      if (piece.west < east && piece.east > west && piece.south < north && piece.north > south) pen.stroke(piece.path);
    }
  }
}

export class Land {
  constructor(run, length, fans) {
    this.shares = landShares(run);
    this.broad = BROAD * length;
    this.ways = new Lines();
    this.areas = new Path2D();
    this.slopes = [];
    this.levels = new Map(); // height -> its ways and its areas
    const { nodes, edges } = run;
    const { shares } = this;
    const rings = ringsOf(fans);
    const filled = fillings(run, fans, rings, shares, length);
    for (let e = 0; e < edges.a.length; e++) {
      const [p, q] = [edges.a[e], edges.b[e]];
      const ends = [nodes.x[p], nodes.y[p], nodes.x[q], nodes.y[q]];
      const low = Math.min(shares[p], shares[q]);
      if (!edges.rise[e] && filled[2 * e] === low && filled[2 * e + 1] === low) continue; // land on either side
      this.ways.add(...ends);
      if (edges.rise[e]) this.slopes.push([ends, shares[p], shares[q]]);
      else this.level(low).ways.add(...ends);
    }
    this.addAreas(run, fans, filled);
    fans.fans.forEach((fan, node) => this.roundCorners(run, fans, fan, filled, node, length));
    this.heights = [...this.levels.keys()].sort((one, other) => one - other);
  }

  level(share) {
    const height = Math.fround(share);
    if (!this.levels.has(height)) this.levels.set(height, { ways: new Lines(), areas: new Path2D() });
    return this.levels.get(height);
  }

  add(share, draw) {
    draw(this.areas);
    draw(this.level(share).areas);
  }

  /** Adds the rings that are filled, neighbours of one height as one area. */
  addAreas({ nodes }, { fans, place, from }, filled) {
    const after = (half) => fans[from[half ^ 1]][(place[half ^ 1] + fans[from[half ^ 1]].length - 1) % fans[from[half ^ 1]].length];
    const done = new Uint8Array(from.length);
    for (let start = 0; start < from.length; start++) {
      if (done[start] || filled[start] < 0 || filled[start ^ 1] === filled[start]) continue;
      const coast = [];
      for (let half = start; !done[half];) {
        done[half] = 1;
        coast.push(from[half]);
        half = after(half);
        while (filled[half ^ 1] === filled[half]) half = after(half ^ 1);
      }
      this.add(filled[start], (path) => {
        coast.forEach((node, i) => (i ? path.lineTo(nodes.x[node], nodes.y[node]) : path.moveTo(nodes.x[node], nodes.y[node])));
        path.closePath();
      });
    }
  }

  /** Fills the corner between each two neighbouring edges of a node up to an arc that touches both ways. */
  roundCorners({ nodes, edges }, { angle }, fan, filled, node, length) {
    const half = this.broad / 2;
    const [x, y] = [nodes.x[node], nodes.y[node]];
    const long = (one) => Math.hypot(nodes.x[edges.a[one >> 1]] - nodes.x[edges.b[one >> 1]], nodes.y[edges.a[one >> 1]] - nodes.y[edges.b[one >> 1]]);
    fan.forEach((one, i) => {
      const other = fan[(i + 1) % fan.length];
      const between = (angle[other] - angle[one] + 2 * Math.PI) % (2 * Math.PI);
      if (fan.length < 2 || filled[one] >= 0 || between < NARROWEST || between > WIDEST) return;
      const reach = half / Math.tan(between / 2); // from the node to beside the corner, along either edge
      const far = Math.min(ROUND * length, long(one) - reach, long(other) - reach);
      if (far <= 0) return;
      const middle = angle[one] + between / 2, out = half / Math.sin(between / 2);
      const corner = [x + out * Math.cos(middle), y + out * Math.sin(middle)];
      const along = (way) => [corner[0] + far * Math.cos(way), corner[1] + far * Math.sin(way)];
      this.add(this.shares[node], (path) => {
        // Against the clock, as the areas are: where they overlap, neither takes the other away.
        path.moveTo(x, y);
        path.lineTo(...along(angle[one]));
        path.quadraticCurveTo(...corner, ...along(angle[other]));
        path.closePath();
      });
    });
  }

  /** Draws water, coast and land on a pen whose unit is a pixel; `bare` leaves all but the land away. */
  draw(pen, { camera, colours }, bare = false) {
    pen.save();
    pen.translate(camera.width / 2, camera.height / 2);
    pen.scale(camera.scale, -camera.scale);
    pen.translate(-camera.x, -camera.y);
    pen.lineCap = pen.lineJoin = "round";
    const room = this.broad + 12 / camera.scale;
    const [x, y] = [camera.width / 2 / camera.scale + room, camera.height / 2 / camera.scale + room];
    const seen = [camera.x - x, camera.y - y, camera.x + x, camera.y + y];
    if (!bare) {
      for (const [pixels, share] of WATERLINES) this.outline(pen, seen, pixels / camera.scale, style(mix(colours.sky, colours.coast, share)));
      this.outline(pen, seen, 1.5 / camera.scale, colours.css.coast);
    }
    const colour = (share) => style(mix(colours["land-low"], colours["land-high"], share));
    pen.lineWidth = this.broad;
    for (const share of this.heights) {
      const { ways, areas } = this.levels.get(share);
      pen.strokeStyle = pen.fillStyle = colour(share);
      pen.fill(areas);
      ways.stroke(pen, seen);
    }
    // A slope ends at its nodes, in the colours that they have; round first, for the corners of the place.
    for (const cap of this.slopes.length ? ["round", "butt"] : []) {
      pen.lineCap = cap;
      for (const [ends, from, to] of this.slopes) {
        const shade = pen.createLinearGradient(...ends);
        shade.addColorStop(0, colour(from));
        shade.addColorStop(1, colour(to));
        pen.strokeStyle = shade;
        pen.beginPath();
        segment(pen, ...ends);
        pen.stroke();
      }
    }
    pen.restore();
  }

  outline(pen, seen, more, colour) {
    pen.strokeStyle = pen.fillStyle = colour;
    pen.lineWidth = this.broad + 2 * more;
    this.ways.stroke(pen, seen);
    pen.lineWidth = 2 * more;
    pen.fill(this.areas);
    pen.stroke(this.areas);
  }
}
