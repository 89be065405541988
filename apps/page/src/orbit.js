// Where the eye is: an orthographic camera that mouse, touch and keys turn, move and bring nearer.
import { OrthographicCamera, Quaternion, Vector3 } from "three";

const farAway = 4; // sizes of the mesh
const mostZoom = 1e6;

export class Orbit {
  /// `size`: of the mesh; `flat`: a 2D mesh, which is not turned. `changed` is called after every move.
  constructor(element, { size, flat }, changed) {
    this.element = element;
    this.size = size;
    this.flat = flat;
    this.changed = changed;
    this.camera = new OrthographicCamera();
    this.target = new Vector3();
    this.turn = new Quaternion();
    this.height = size; // of what is seen
    this.pointers = new Map();
    element.addEventListener("pointerdown", (event) => this.down(event));
    element.addEventListener("pointermove", (event) => this.moved(event));
    for (const end of ["pointerup", "pointercancel"])
      element.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    element.addEventListener("wheel", (event) => this.wheeled(event), { passive: false });
    element.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  get pixelsPerUnit() {
    return this.element.clientHeight / this.height;
  }

  update() {
    const { camera, aspect } = this;
    camera.top = this.height / 2;
    camera.bottom = -camera.top;
    camera.right = camera.top * aspect;
    camera.left = -camera.right;
    camera.near = 0;
    camera.far = 2 * farAway * this.size;
    camera.quaternion.copy(this.turn);
    camera.position.set(0, 0, farAway * this.size).applyQuaternion(this.turn).add(this.target);
    camera.updateProjectionMatrix();
    camera.updateMatrixWorld();
    this.changed();
  }

  /// Looks along `direction` with `up` upwards.
  lookAlong(direction, up) {
    const back = new Vector3(...direction).negate().normalize();
    const right = new Vector3(...up).cross(back).normalize();
    const above = back.clone().cross(right);
    const { x, y, z, w } = new Quaternion().setFromRotationMatrix(this.camera.matrix.clone().makeBasis(right, above, back));
    this.turn.set(x, y, z, w);
    this.update();
  }

  get aspect() {
    return this.element.clientWidth / Math.max(this.element.clientHeight, 1);
  }

  /// Brings a ball into view.
  show(centre, radius) {
    this.target.set(...centre);
    this.height = (2 * radius) / Math.min(1, this.aspect);
    this.update();
  }

  /// Brings into view what is in a box around the origin, and no farther from there than `radius`.
  showBox(halves, radius) {
    const reach = (axis) => {
      const along = new Vector3(...axis).applyQuaternion(this.turn);
      const sum = halves[0] * Math.abs(along.x) + halves[1] * Math.abs(along.y) + halves[2] * Math.abs(along.z);
      return Math.min(sum, radius);
    };
    this.show([0, 0, 0], 1.1 * Math.max(reach([0, 1, 0]) * Math.min(1, this.aspect), reach([1, 0, 0]) / Math.max(1, this.aspect)));
  }

  /// By parts of the window: right and up. Along great circles as seen, so that no pole is in the way.
  rotate(right, up) {
    if (this.flat) return this.pan(right / 4, up / 4);
    const about = (axis, angle) => this.turn.multiply(new Quaternion().setFromAxisAngle(axis, angle));
    about(new Vector3(0, 1, 0), -right * Math.PI);
    about(new Vector3(1, 0, 0), up * Math.PI);
    this.turn.normalize();
    this.update();
  }

  /// The mesh goes by parts of the window's height.
  pan(right, up) {
    this.target.sub(new Vector3(right * this.height, up * this.height, 0).applyQuaternion(this.turn));
    this.update();
  }

  /// Nearer by `factor`; what is at (x, y), in parts of the height from the middle, stays there.
  zoom(factor, x = 0, y = 0) {
    const limited = Math.min(Math.max(this.height / factor, this.size / mostZoom), 10 * this.size);
    const shift = this.height - limited;
    this.height = limited;
    this.target.add(new Vector3(x * shift, y * shift, 0).applyQuaternion(this.turn));
    this.update();
  }

  /// How much the eye is on the positive side of an axis, from -1 to 1.
  seenFrom(axis) {
    return new Vector3(0, 0, 1).applyQuaternion(this.turn).getComponent(axis);
  }

  /// A point of space in pixels of the element.
  pixelOf(point) {
    const seen = new Vector3(...point).project(this.camera);
    return [((seen.x + 1) / 2) * this.element.clientWidth, ((1 - seen.y) / 2) * this.element.clientHeight];
  }

  partsOf(event) {
    const box = this.element.getBoundingClientRect();
    return [(event.clientX - box.left - box.width / 2) / box.height, (box.top + box.height / 2 - event.clientY) / box.height];
  }

  down(event) {
    this.element.setPointerCapture(event.pointerId);
    this.element.focus({ preventScroll: true });
    this.pointers.set(event.pointerId, this.partsOf(event));
  }

  moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = this.partsOf(event);
    const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId);
    this.pointers.set(event.pointerId, now);
    if (others.length > 0) this.pinched(before, now, others[0][1]);
    else if (this.flat || event.buttons & 6 || event.shiftKey) this.pan(dx, dy);
    else this.rotate(dx, dy);
  }

  /// One of two fingers moves.
  pinched(before, now, other) {
    const apart = (a) => Math.hypot(a[0] - other[0], a[1] - other[1]);
    this.pan((now[0] - before[0]) / 2, (now[1] - before[1]) / 2);
    if (apart(before) > 0.01) this.zoom(apart(now) / apart(before), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
  }

  wheeled(event) {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 16 : 1);
    this.zoom(Math.exp(-pixels / 500), ...this.partsOf(event));
  }
}
