// Colours: those of the page come from its style sheet, those of pheromones from matplotlib's viridis, as in the plots.

const VIRIDIS = [
  "440154", "481f70", "443983", "3b528b", "31688e", "287c8e", "21918c", "20a486", "35b779", "5ec962", "90d743",
  "c8e020", "fde725",
].map((hex) => [0, 2, 4].map((at) => parseInt(hex.slice(at, at + 2), 16)));

/** Red, green and blue of a share from 0 to 1. */
export function scaleColour(share) {
  const at = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1);
  const below = Math.min(Math.floor(at), VIRIDIS.length - 2);
  return VIRIDIS[below].map((low, i) => Math.round(low + (at - below) * (VIRIDIS[below + 1][i] - low)));
}

/** The same as text for a style. */
export const scaleStyle = (share) => `rgb(${scaleColour(share).join()})`;

/** A colour that can be read on `scaleStyle(share)`. */
export const onScale = (share) => (share > 0.6 ? "#101010" : "#ffffff");

const NAMES = [
  "paper", "card", "ink", "quiet", "line", "accent", "agent", "agent-line", "box", "box-line", "goal", "hole",
  "hole-line", "blocked", "waiting", "land-low", "land-high", "coast", "way", "node", "node-line", "sky",
];

/** The page's colours as they are now, light or dark: name -> [red, green, blue], and name -> style in `css`. */
export function readColours() {
  const probe = document.createElement("i");
  document.body.append(probe);
  const colours = { css: {} };
  for (const name of NAMES) {
    probe.style.color = `var(--${name})`;
    const style = getComputedStyle(probe).color;
    colours[name] = style.match(/[\d.]+/g).slice(0, 3).map(Number);
    colours.css[name] = style;
  }
  probe.remove();
  return colours;
}

/** A colour between two. */
export const mix = (one, other, share) => one.map((value, i) => Math.round(value + share * (other[i] - value)));
export const style = (colour) => `rgb(${colour.join()})`;
