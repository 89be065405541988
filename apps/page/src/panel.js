// What is beside the picture and steers it: colours, cut, the worst elements, tools.
import { showLegend } from "./colours.js";
import { drawnRange } from "./view.js";

const $ = (id) => document.getElementById(id);
const axes = ["x", "y", "z"];

/// A coordinate to a thousandth of the mesh's extent.
const rounded = (x, extent) => Number(x.toFixed(Math.min(Math.max(3 - Math.floor(Math.log10(extent)), 0), 20)));

export class Panel {
  constructor(page, view) {
    Object.assign(this, { page, view, whole: true, lines: true, axis: -1, side: 1, chosen: null });
    this.quantity = page.quantities[0] ?? null;
    this.colours();
    this.groups = new Groups(page, (hidden) => view.setHidden(hidden));
    this.cutting();
    this.worst();
    for (const button of document.querySelectorAll("[data-do]")) button.onclick = () => this[button.dataset.do]();
    view.drawn = () => this.placePin();
  }

  async start() {
    this.wholeView();
    await this.paint();
  }

  // colours

  colours() {
    const select = $("colour");
    for (const q of this.page.quantities) select.add(new Option(q.title, q.key));
    select.add(new Option("none", ""));
    select.onchange = () => this.colourBy(select.selectedIndex);
    $("whole").onchange = (event) => {
      this.whole = event.target.checked;
      this.paint();
    };
    $("lines").onchange = () => this.setLines($("lines").checked);
  }

  colourBy(index) {
    $("colour").selectedIndex = index;
    this.quantity = this.page.quantities[index] ?? null;
    this.paint();
  }

  nextColour() {
    this.colourBy(($("colour").selectedIndex + 1) % $("colour").length);
  }

  async paint() {
    const q = this.quantity;
    const range = q ? drawnRange(q, this.whole) : [0, 1];
    $("wholeLabel").hidden = !q?.whole;
    showLegend($("legend"), q, range);
    await this.view.setQuantity(q, range);
  }

  setLines(on) {
    this.lines = $("lines").checked = on;
    this.view.setLines(on);
  }

  switchLines() {
    this.setLines(!this.lines);
  }

  // the cut: along an axis, at those steps where the page has the faces that it uncovers

  cutting() {
    const { cut } = this.page;
    axes.forEach((name, axis) => {
      const button = $(`cut-${name}`);
      button.hidden = axis >= this.page.dimension || cut.places[axis].length === 0;
      button.onclick = () => this.cutAlong(this.axis === axis ? -1 : axis);
    });
    $("place").oninput = () => this.cutAt(Number($("place").value));
    $("side").onchange = () => {
      this.side = $("side").checked ? -1 : 1;
      this.applyCut();
    };
    $("cutNote").textContent = cut.note;
  }

  cutAlong(axis) {
    this.axis = axis;
    axes.forEach((name, i) => $(`cut-${name}`).setAttribute("aria-pressed", String(i === axis)));
    $("cutPlace").hidden = axis < 0;
    if (axis < 0) return this.applyCut();
    const places = this.page.cut.places[axis];
    this.side = this.view.orbit.seenFrom(axis) < -1e-6 ? -1 : 1; // what is nearer goes
    $("side").checked = this.side < 0;
    $("place").max = places.length - 1;
    const middle = places.reduce((best, p, i) => (Math.abs(p - 127) < Math.abs(places[best] - 127) ? i : best), 0);
    this.cutAt(middle);
  }

  cutAt(index) {
    const last = Number($("place").max);
    $("place").value = this.index = Math.min(Math.max(index, 0), last);
    this.applyCut();
  }

  moveCut(by) {
    if (this.axis >= 0) this.cutAt(this.index + by);
  }

  applyCut() {
    const { axis, side } = this;
    if (axis < 0) return this.view.setCut({});
    this.choose(null);
    const step = this.page.cut.places[axis][this.index];
    const { low, high, steps } = this.page.cut;
    const at = low[axis] + ((high[axis] - low[axis]) * (step + 1)) / (steps + 1);
    $("cutText").textContent = `${axes[axis]} ${side > 0 ? "≤" : ">"} ${rounded(at, high[axis] - low[axis])}`;
    this.view.setCut({ axis, cut: step + 0.5, side });
  }

  // the worst elements

  worst() {
    this.page.worst.forEach((_, i) => ($(`worst-${i}`).onclick = () => this.choose(this.chosen === i ? null : i)));
  }

  choose(index) {
    if (index !== null && index >= this.page.worst.length) return;
    const was = this.chosen;
    this.chosen = index;
    this.page.worst.forEach((_, i) => $(`worst-${i}`).setAttribute("aria-pressed", String(i === index)));
    this.view.choose(index);
    if (index !== null) {
      const { centre, radius } = this.page.worst[index];
      this.view.orbit.show(centre, 2.2 * radius);
    } else if (was !== null) this.fit();
  }

  placePin() {
    const worst = this.page.worst[this.chosen];
    $("pin").hidden = !worst?.point;
    if (!worst?.point) return;
    const [x, y] = this.view.orbit.pixelOf(worst.point);
    $("pin").style.transform = `translate(${x}px, ${y}px)`;
  }

  // where the eye is

  fit() {
    const { cut, radius } = this.page;
    const halves = cut.high.map((high, i) => (high - cut.low[i]) / 2);
    this.view.orbit.showBox(halves, radius);
  }

  wholeView() {
    if (this.page.dimension === 3) this.view.orbit.lookAlong([-0.62, 0.7, -0.46], [0, 0, 1]);
    this.fit();
  }

  alongX() {
    if (this.page.dimension === 3) this.view.orbit.lookAlong([-1, 0, 0], [0, 0, 1]);
  }
  alongY() {
    if (this.page.dimension === 3) this.view.orbit.lookAlong([0, 1, 0], [0, 0, 1]);
  }
  alongZ() {
    if (this.page.dimension === 3) this.view.orbit.lookAlong([0, 0, -1], [0, 1, 0]);
  }

  nearer() {
    this.view.orbit.zoom(1.25);
  }
  farther() {
    this.view.orbit.zoom(0.8);
  }

  switchTheme() {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
    this.view.ask();
  }

  switchHelp() {
    $("help").hidden = !$("help").hidden;
  }

  clear() {
    $("help").hidden = true;
    this.choose(null);
    this.cutAlong(-1);
  }
}

// ---------------------------------------------------------------- groups

const headings = { elements: "Elements", faces: "Boundary" };

function checkBox(text, change) {
  const label = document.createElement("label");
  const box = document.createElement("input");
  box.type = "checkbox";
  box.checked = true;
  box.onchange = change;
  label.append(box, " ", text);
  return { label, box };
}

/// Check boxes for the groups of elements and of the boundary. A page without several groups has no list.
class Groups {
  constructor(page, apply) {
    this.apply = apply;
    this.lists = page.quantities.filter((q) => q.scale === "categories").map((quantity) => this.list(quantity));
    $("groups").hidden = this.lists.length === 0;
    $("groupsAll").onclick = () => this.setAll(true);
    $("groupsNone").onclick = () => this.setAll(false);
  }

  list(quantity) {
    const heading = document.createElement("h3");
    heading.textContent = headings[quantity.on];
    $("groupList").append(heading);
    const boxes = quantity.categories.map((reference, i) => {
      const name = quantity.names?.[i];
      const { label, box } = checkBox(name ? `${name} (${reference})` : String(reference), () => this.changed());
      box.id = `group-${quantity.on}-${reference}`;
      $("groupList").append(label);
      return { reference, box };
    });
    return { quantity, boxes };
  }

  setAll(checked) {
    for (const { boxes } of this.lists) for (const { box } of boxes) box.checked = checked;
    this.changed();
  }

  changed() {
    this.apply(
      this.lists.map(({ quantity, boxes }) => ({
        quantity,
        references: new Set(boxes.filter(({ box }) => !box.checked).map(({ reference }) => reference)),
      })),
    );
  }
}
