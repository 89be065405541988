// The picture: the faces that there are, how they are coloured and cut, and which of the worst elements stands out.
import { Color, CustomBlending, DoubleSide, GLSL3, OneFactor, OneMinusSrcAlphaFactor, RawShaderMaterial, Scene, WebGLRenderer } from "three";

import { badColour, paletteTexture } from "./colours.js";
import { drawnOwners, valuesOf } from "./mesh.js";
import { Orbit } from "./orbit.js";
import { patches, refine, setDrawn, setValues } from "./patches.js";
import { fragmentShader, vertexShader } from "./shaders.js";

const rgb = (hex) => new Color().setStyle(hex, "");
/// Of edges, in pixels of the screen.
const lineWidth = () => 1.3 * Math.min(window.devicePixelRatio, 2);
const none = { axis: -1, cut: 0, side: 1 };

const range = (begin, count) => Array.from({ length: count }, (_, i) => begin + i);

export class View {
  constructor(canvas, page, mesh) {
    Object.assign(this, { canvas, page, mesh });
    this.renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.scene = new Scene();
    this.orbit = new Orbit(canvas, { size: page.radius, flat: page.dimension === 2 }, () => this.ask());
    this.shared = this.uniforms();
    this.materials = new Map();
    this.chosen = null; // of the worst
    this.uncovers = false; // true if elements of a group are hidden
    this.drawn = () => {};
    const { faces, inner, worst } = page.counts;
    this.outer = this.add(range(0, faces));
    this.inner = this.add(range(faces, inner));
    this.worst = page.worst.map(({ first, count }) => this.add(range(faces + inner + first, count)));
    this.setCut(none);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.ask());
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  uniforms() {
    const value = (v) => ({ value: v });
    return {
      palette: value(null),
      range: value([0, 1]),
      logarithmic: value(false),
      plain: value(false),
      flatLight: value(this.page.dimension === 2),
      badBelow: value(-Infinity),
      badColour: value(rgb(badColour)),
      plainColour: value(rgb("#c9d3de")),
      lineColour: value(rgb("#141c28")),
      inkColour: value(new Color()),
      lines: value(lineWidth()),
    };
  }

  add(faces) {
    const objects = patches(this.mesh, this.page, faces, null);
    for (const object of objects) this.scene.add(object);
    return objects;
  }

  /// A material for each way of values and of standing out; all share what is the same.
  material(nodal, ghost, cut) {
    const key = `${nodal} ${ghost} ${cut}`;
    if (this.materials.has(key)) return this.materials.get(key);
    const material = new RawShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: vertexShader(nodal),
      fragmentShader,
      side: DoubleSide,
      uniforms: { ...this.shared, ghost: { value: ghost }, ...this.cutUniforms(cut) },
    });
    if (ghost)
      Object.assign(material, {
        transparent: true,
        depthWrite: false,
        blending: CustomBlending,
        blendSrc: OneFactor,
        blendDst: OneMinusSrcAlphaFactor,
      });
    this.materials.set(key, material);
    return material;
  }

  cutUniforms(cut) {
    this.cutting ??= { axis: { value: -1 }, cut: { value: 0 }, side: { value: 1 } };
    return cut ? this.cutting : { axis: { value: -1 }, cut: { value: 0 }, side: { value: 1 } };
  }

  get everything() {
    return [...this.outer, ...this.inner, ...this.worst.flat()];
  }

  async setQuantity(quantity, [low, high]) {
    const plain = !quantity;
    this.shared.plain.value = plain;
    this.nodal = !plain && quantity.on === "nodes";
    if (!plain && this.quantity !== quantity) {
      setValues(this.everything, this.mesh, quantity, await quantityValues(quantity));
      this.shared.palette.value?.dispose();
      this.shared.palette.value = paletteTexture(quantity);
    }
    this.quantity = quantity;
    if (!plain) {
      const log = quantity.scale === "log";
      this.shared.logarithmic.value = log;
      this.shared.range.value = log ? [Math.log(low), Math.log(high)] : [low, high];
      this.shared.badBelow.value = quantity.bad ?? -Infinity;
    }
    this.dress();
  }

  setLines(on) {
    this.shared.lines.value = on ? lineWidth() : 0;
    this.ask();
  }

  setCut(cut) {
    this.cut = { ...none, ...cut };
    this.cutUniforms(true);
    for (const name of Object.keys(this.cutting)) this.cutting[name].value = this.cut[name];
    this.dress();
  }

  /// Hides groups: for each quantity of references, those that are not drawn.
  async setHidden(groups) {
    const drawn = await drawnOwners(this.mesh, this.page.counts, groups);
    this.uncovers = groups.some(({ quantity, references }) => quantity.on === "elements" && references.size > 0);
    setDrawn([...this.outer, ...this.inner], drawn);
    this.dress();
  }

  /// Which of the worst stands out, the others of the mesh being seen through; null: none.
  choose(index) {
    this.chosen = index;
    this.dress();
  }

  /// Gives all their materials.
  dress() {
    const ghost = this.chosen !== null;
    for (const object of [...this.outer, ...this.inner]) object.material = this.material(this.nodal ?? false, ghost, true);
    for (const object of this.inner) object.visible = (this.cut.axis >= 0 || this.uncovers) && !ghost;
    this.worst.forEach((objects, i) =>
      objects.forEach((object) => {
        object.visible = i === this.chosen;
        object.material = this.material(this.nodal ?? false, false, false);
      }),
    );
    this.ask();
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight);
    this.orbit.update();
  }

  /// Draws once before the screen is next refreshed.
  ask() {
    this.asked ??= requestAnimationFrame(() => {
      this.asked = null;
      this.draw();
    });
  }

  draw() {
    if (this.quantity === undefined) return;
    this.shared.inkColour.value.setStyle(getComputedStyle(document.body).color, "");
    refine(this.everything.filter((o) => o.visible), this.orbit.pixelsPerUnit * this.renderer.getPixelRatio());
    this.renderer.render(this.scene, this.orbit.camera);
    this.drawn();
  }
}

/// Values as they are drawn: categories by their number.
async function quantityValues(quantity) {
  const values = await valuesOf(quantity);
  if (quantity.scale !== "categories") return values;
  const number = new Map(quantity.categories.map((c, i) => [c, i]));
  return Float32Array.from(values, (v) => number.get(v) ?? NaN);
}

/// The range that is drawn of a quantity: all that it can be, where it has such, or what there is.
export function drawnRange(quantity, whole) {
  if (quantity.scale === "categories") return [-0.5, quantity.categories.length - 0.5];
  return whole && quantity.whole ? quantity.whole : quantity.range;
}

