// The person's gamepad: of all that the browser lists, the one that was moved first. Others may lie
// on the table, and keyboards and mice may say that they are gamepads. One whose layout the browser
// does not know is not used: its triggers may rest at -1, and its Start may be where a trigger is.

/** @typedef {{axes: Set<number>, buttons: Set<number>, said: boolean}} Seen  what of it has been at rest; whether it was said that it is not used */

const kRest = 0.12;   // an axis or a button within this is at rest
const kMoved = 0.5;   // and one that goes so far from there was moved

export class Pads {
  /** @param {(text: string) => void} say */
  constructor(say) {
    this.say = say;
    /** @type {Map<string, Seen>} */
    this.seen = new Map();
    this.chosen = '';
  }

  /** @returns {Gamepad | null} */
  own() {
    /** @type {Map<string, Gamepad>} */
    const there = new Map();
    for (const pad of navigator.getGamepads?.() ?? []) if (pad?.connected) there.set(`${pad.index} ${pad.id}`, pad);
    for (const name of this.seen.keys()) if (!there.has(name)) this.seen.delete(name);
    if (!there.has(this.chosen)) this.chosen = '';
    for (const [name, pad] of there) this.look(name, pad);
    return there.get(this.chosen) ?? null;
  }

  /** @param {string} name @param {Gamepad} pad */
  look(name, pad) {
    const seen = this.seen.get(name) ?? {axes: new Set(), buttons: new Set(), said: false};
    this.seen.set(name, seen);
    let moved = false;
    const one = (/** @type {Set<number>} */ rested, /** @type {number} */ i, /** @type {number} */ size) => {
      if (size < kRest) rested.add(i);
      moved ||= size > kMoved && rested.has(i);
    };
    pad.axes.forEach((x, i) => one(seen.axes, i, Math.abs(x)));
    pad.buttons.forEach(({pressed, value}, i) => one(seen.buttons, i, pressed ? 1 : value));
    if (!moved || this.chosen || seen.said) return;
    if (pad.mapping === 'standard') {
      this.chosen = name;
      return;
    }
    seen.said = true;
    this.say(`The gamepad "${pad.id.slice(0, 60)}" is not used: this browser does not know its layout. Keys and mouse are.`);
  }

  /** An axis of it, once that has been at rest. @param {Gamepad} pad @param {number} i */
  axis(pad, i) {
    return this.seen.get(this.chosen)?.axes.has(i) ? pad.axes[i] ?? 0 : 0;
  }

  /** How far a button of it is down, once that has been up. @param {Gamepad} pad @param {number} i */
  button(pad, i) {
    return this.seen.get(this.chosen)?.buttons.has(i) ? pad.buttons[i]?.value ?? 0 : 0;
  }

  /** @param {Gamepad} pad @param {number} i */
  pressed(pad, i) {
    return this.seen.get(this.chosen)?.buttons.has(i) === true && pad.buttons[i]?.pressed === true;
  }
}
