// The hand of the person: mouse, keys and gamepad as one velocity, a share of full deflection in
// the ferrule's frame (insertion is -x; along the axis, as seen, right is -z).

import {Pads} from './pads.js';

/** @typedef {[number, number, number]} Share */

const kRamp = 0.7;        // a key comes to full deflection in so many seconds ...
const kTap = 0.12;        // ... from this: a tap is a small move
const kDrag = 110;        // pixels of drag for full deflection
const kDeadZone = 0.12;   // of a stick or trigger
const kWheelLast = 140;   // a notch of the wheel pushes so long [ms]

export class Hand {
  /**
   * @param {() => boolean} driving whether keys are the hand's now @param {() => void} changed  it has another velocity
   * @param {(text: string) => void} say
   */
  constructor(driving, changed, say) {
    this.driving = driving;
    this.changed = changed;
    this.pads = new Pads(say);
    /** @type {Map<string, {since: number, way: Share}>} what is held, since when [ms], by code */
    this.keys = new Map();
    /** @type {Share} */
    this.drag = [0, 0, 0];
    this.wheel = {share: 0, until: 0};
    this.slow = false;
    this.pressed = false;  // of the gamepad, what starts
    addEventListener('keydown', (event) => this.key(event, true));
    addEventListener('keyup', (event) => this.key(event, false));
    addEventListener('blur', () => this.letGo());
    document.addEventListener('visibilitychange', () => { if (document.hidden) this.letGo(); });
  }

  letGo() {
    this.keys.clear();
    this.drag = [0, 0, 0];
    this.wheel.until = 0;
  }

  /** @param {KeyboardEvent} event @param {boolean} down */
  key(event, down) {
    if (event.code === 'KeyF') this.slow = down && !typing(event);
    const way = keyWay(event);
    if (!way) {
      if (!down && event.key === 'Shift') this.keys.clear();  // arrows change their meaning
      return;
    }
    if (!down) {
      this.keys.delete(event.code);
      this.changed();
      return;
    }
    if (!this.driving() || event.ctrlKey || event.metaKey || typing(event)) return;
    event.preventDefault();
    const held = this.keys.get(event.code);
    this.keys.set(event.code, {since: held?.since ?? performance.now(), way});
    if (!held) this.changed();
  }

  /** Drag in a view drives: `right` and `up` are the axes that the view shows there. @param {HTMLElement} view @param {Share} right @param {() => Share} up */
  dragIn(view, right, up) {
    /** @type {{x: number, y: number} | null} */
    let from = null;
    view.addEventListener('pointerdown', (event) => {
      if (!this.driving() || event.button !== 0) return;
      from = {x: event.clientX, y: event.clientY};
      view.setPointerCapture(event.pointerId);
    });
    view.addEventListener('pointermove', (event) => {
      if (!from) return;
      const unit = kDrag * parseFloat(getComputedStyle(document.documentElement).fontSize) / 14;
      const dx = shaped((event.clientX - from.x) / unit), dy = shaped((from.y - event.clientY) / unit);
      const upward = up();
      this.drag = /** @type {Share} */ ([0, 1, 2].map((i) => right[i] * dx + upward[i] * dy));
    });
    const end = () => {
      from = null;
      this.drag = [0, 0, 0];
    };
    view.addEventListener('pointerup', end);
    view.addEventListener('pointercancel', end);
    view.addEventListener('wheel', (event) => {
      if (!this.driving()) return;
      event.preventDefault();
      const share = Math.max(-1, Math.min(1, event.deltaY / 120));  // away from the person: in
      this.wheel = {share: share * (event.shiftKey ? 1 : 0.5), until: performance.now() + kWheelLast};
    }, {passive: false});
  }

  /** Its velocity now, each within -1..1. @returns {Share} */
  velocity() {
    const now = performance.now();
    /** @type {Share} */
    const v = [...this.drag];
    for (const {since, way} of this.keys.values()) {
      const share = Math.min(1, kTap + (1 - kTap) * (now - since) / 1e3 / kRamp);
      for (let i = 0; i < 3; ++i) v[i] += way[i] * share;
    }
    if (now < this.wheel.until) v[0] += this.wheel.share;
    const pad = this.pad();
    if (pad) for (let i = 0; i < 3; ++i) v[i] += pad[i];
    const slow = this.slow ? 0.2 : 1;
    for (let i = 0; i < 3; ++i) v[i] = slow * Math.max(-1, Math.min(1, v[i]));
    return v;
  }

  /** Whether what starts and stops went down on the gamepad since the last time. */
  started() {
    const pad = this.pads.own(), before = this.pressed;
    this.pressed = pad !== null && this.pads.share(pad, 'start') > 0.5;
    return this.pressed && !before;
  }

  /** @returns {Share | null} */
  pad() {
    const pad = this.pads.own();
    if (!pad) return null;
    const along = (/** @type {import('./pads.js').Way} */ to, /** @type {import('./pads.js').Way} */ back) => this.pads.share(pad, to, live) - this.pads.share(pad, back, live);
    return [along('out', 'in'), along('up', 'down'), along('left', 'right')];
  }

  /** Contact force felt in the gamepad. @param {number} share of the limit */
  rumble(share) {
    const pad = this.pads.own();
    const actuator = pad && 'vibrationActuator' in pad ? pad.vibrationActuator : null;
    if (!actuator || share < 0.02) return;
    actuator.playEffect('dual-rumble', {
      duration: 80, strongMagnitude: Math.min(1, share), weakMagnitude: Math.min(1, 2 * share),
    }).catch(() => undefined);  // it may be gone
  }
}

/** What a key does. @param {KeyboardEvent} event @returns {Share | null} */
function keyWay(event) {
  const axial = event.shiftKey;
  switch (event.code) {
    case 'ArrowUp': return axial ? [-1, 0, 0] : [0, 1, 0];
    case 'ArrowDown': return axial ? [1, 0, 0] : [0, -1, 0];
    case 'ArrowLeft': return axial ? null : [0, 0, 1];
    case 'ArrowRight': return axial ? null : [0, 0, -1];
    case 'PageUp': case 'KeyW': return [-1, 0, 0];
    case 'PageDown': case 'KeyS': return [1, 0, 0];
    default: return null;
  }
}

/** Whether a key is for what has the focus. @param {KeyboardEvent} event */
export function typing({target, key}) {
  if (!(target instanceof HTMLElement)) return false;
  if (target instanceof HTMLInputElement) {
    if (target.type === 'checkbox') return key === ' ';
    if (target.type === 'range' || target.type === 'radio') return key.startsWith('Arrow') || key.startsWith('Page') || key === 'Home' || key === 'End' || (key === ' ' && target.type === 'radio');
    return true;
  }
  if (target.dataset.keys !== undefined) return key.startsWith('Arrow') || key === '+' || key === '=' || key === '-';
  return target instanceof HTMLSelectElement || target instanceof HTMLTextAreaElement || target.isContentEditable;
}

/** Fine near the middle. @param {number} x */
function shaped(x) {
  const size = Math.min(1, Math.abs(x));
  return Math.sign(x) * size ** 1.6;
}

/** Without the dead zone of a stick or trigger; a stick is fine near the middle. @param {number} x @param {string} input */
function live(x, input) {
  const size = Math.max(0, x - kDeadZone) / (1 - kDeadZone);
  return input.startsWith('a') ? shaped(size) : size;
}
