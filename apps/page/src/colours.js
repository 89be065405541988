// Colours by value: blends of a few through OKLab (B. Ottosson, 2020), in which equal steps look equal; and their legend.
import { DataTexture, LinearFilter, NearestFilter } from "three";

const stops = {
  good: ["#8c1d40", "#d9532c", "#f6b04b", "#f6edc4", "#a9d8cc", "#6fb3d2", "#4f8fc4"], // from bad to good
  sequence: ["#1d2158", "#453b8f", "#8a4a9a", "#c9587f", "#f08062", "#fbb96b", "#fbf3b9"], // from little to much
};
const categoryColours = ["#4c78a8", "#f2a154", "#63a375", "#d1605e", "#8d78b8", "#7fbfc4", "#e0c35a", "#b07d62", "#e08fb0", "#8c9aa6"];
export const badColour = "#e5007d";

const parse = (hex) => [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
const toLinear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
const toGamma = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
const times = (rows, v) => rows.map((row) => row.reduce((sum, m, i) => sum + m * v[i], 0));

function labOf(hex) {
  const lms = times(
    [
      [0.4122214708, 0.5363325363, 0.0514459929],
      [0.2119034982, 0.6806995451, 0.1073969566],
      [0.0883024619, 0.2817188376, 0.6299787005],
    ],
    parse(hex).map(toLinear),
  ).map(Math.cbrt);
  return times(
    [
      [0.2104542553, 0.793617785, -0.0040720468],
      [1.9779984951, -2.428592205, 0.4505937099],
      [0.0259040371, 0.7827717662, -0.808675766],
    ],
    lms,
  );
}

function bytesOf(lab) {
  const lms = times(
    [
      [1, 0.3963377774, 0.2158037573],
      [1, -0.1055613458, -0.0638541728],
      [1, -0.0894841775, -1.291485548],
    ],
    lab,
  ).map((c) => c ** 3);
  return times(
    [
      [4.0767416621, -3.3077115913, 0.2309699292],
      [-1.2684380046, 2.6097574011, -0.3413193965],
      [-0.0041960863, -0.7034186147, 1.707614701],
    ],
    lms,
  ).map((c) => Math.round(255 * Math.min(Math.max(toGamma(c), 0), 1)));
}

function blend(hexes, count) {
  const labs = hexes.map(labOf);
  return Array.from({ length: count }, (_, i) => {
    const t = (i / (count - 1)) * (labs.length - 1);
    const k = Math.min(Math.floor(t), labs.length - 2);
    return bytesOf(labs[k].map((c, j) => c + (t - k) * (labs[k + 1][j] - c)));
  });
}

/// The colours of a quantity as bytes: of values from the least to the greatest, or of its categories.
function colours(quantity) {
  if (quantity.scale === "categories")
    return quantity.categories.map((_, i) => parse(categoryColours[i % categoryColours.length]).map((c) => 255 * c));
  return blend(stops[quantity.palette], 256);
}

export function paletteTexture(quantity) {
  const list = colours(quantity);
  const texture = new DataTexture(Uint8Array.from(list.flatMap((c) => [...c, 255])), list.length, 1);
  const filter = quantity.scale === "categories" ? NearestFilter : LinearFilter;
  texture.minFilter = texture.magFilter = filter;
  texture.needsUpdate = true;
  return texture;
}

// ---------------------------------------------------------------- legend

const short = (x) => (x === 0 || (Math.abs(x) >= 1e-3 && Math.abs(x) < 1e5) ? String(Number(x.toPrecision(4))) : x.toExponential(2));
const css = (c) => `rgb(${c.map(Math.round).join(" ")})`;

function element(tag, className, text = "") {
  const made = document.createElement(tag);
  made.className = className;
  made.textContent = text;
  return made;
}

function swatch(colour, text) {
  const row = element("div", "swatch");
  const box = element("i", "");
  box.style.background = colour;
  row.append(box, text);
  return row;
}

function bar(quantity, [low, high]) {
  const steps = colours(quantity).filter((_, i) => i % 15 === 0);
  const strip = element("div", "bar");
  strip.style.background = `linear-gradient(to right, ${steps.map(css).join(", ")})`;
  const middle = quantity.scale === "log" ? Math.sqrt(low * high) : (low + high) / 2;
  const numbers = element("div", "ends");
  for (const x of [low, middle, high]) numbers.append(element("span", "", short(x)));
  return [strip, numbers];
}

const mostShown = 12;

function categoryRows(quantity) {
  const list = colours(quantity);
  const rows = quantity.categories.slice(0, mostShown).map((c, i) => {
    const name = quantity.names?.[i];
    return swatch(css(list[i]), name ? `${name} (${c})` : String(c));
  });
  if (quantity.categories.length > mostShown) rows.push(element("div", "more", `and ${quantity.categories.length - mostShown} more`));
  return rows;
}

/// Shows the meaning of the colours, with the range that they span.
export function showLegend(box, quantity, range) {
  box.replaceChildren();
  box.hidden = !quantity;
  if (!quantity) return;
  box.append(element("h2", "", quantity.title));
  if (quantity.scale === "categories") return box.append(...categoryRows(quantity));
  box.append(...bar(quantity, range));
  const there = quantity.range.map(short);
  box.append(element("div", "more", `in this mesh ${there[0]} to ${there[1]}`));
  if (quantity.bad !== undefined && quantity.range[0] <= quantity.bad)
    box.append(swatch(badColour, `not above ${short(quantity.bad)}: invalid`));
}
