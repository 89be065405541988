// What the colours mean, with the range that they span.
import { badColour, colours } from "./palettes.js";

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

function categories(quantity) {
  const list = colours(quantity);
  const rows = quantity.categories.slice(0, mostShown).map((c, i) => {
    const name = quantity.names?.[i];
    return swatch(css(list[i]), name ? `${name} (${c})` : String(c));
  });
  if (quantity.categories.length > mostShown) rows.push(element("div", "more", `and ${quantity.categories.length - mostShown} more`));
  return rows;
}

export function showLegend(box, quantity, range) {
  box.replaceChildren();
  box.hidden = !quantity;
  if (!quantity) return;
  box.append(element("h2", "", quantity.title));
  if (quantity.scale === "categories") return box.append(...categories(quantity));
  box.append(...bar(quantity, range));
  const there = quantity.range.map(short);
  box.append(element("div", "more", `in this mesh ${there[0]} to ${there[1]}`));
  if (quantity.bad !== undefined && quantity.range[0] <= quantity.bad)
    box.append(swatch(badColour, `not above ${short(quantity.bad)}: invalid`));
}
