// The person's gamepad: of all that the browser lists, the one that was moved first. Others may lie
// on the table, and keyboards and mice may say that they are gamepads. One whose layout the browser
// does not know drives once the person has assigned its sticks and buttons (assignment.js): its
// triggers may rest at -1, and its Start may be where a trigger is.

/** @typedef {{input: string, rest: number, full: number}} Control  an axis "a0" or a button "b0", and what it reads at rest and all the way
 * @typedef {'right' | 'left' | 'up' | 'down' | 'in' | 'out' | 'start'} Way
 * @typedef {Partial<Record<Way, Control[]>>} Layout
 * @typedef {{layout: Layout | null, rested: Set<string>, strange: boolean}} Seen  what of it has been at rest; whether it was moved and is not known */

const kRest = 0.12;           // an input within this is at rest
export const kMoved = 0.5;    // and one that goes so far from there was moved
const kCookie = 'ferrule-gamepad-';

/** @param {string} input @param {number} [full] @returns {Control} */
const of = (input, full = 1) => ({input, rest: 0, full});
/** @type {Layout} what a browser calls "standard" */
const kStandard = {
  right: [of('a0')], left: [of('a0', -1)], up: [of('a1', -1)], down: [of('a1')],
  in: [of('b7'), of('a3', -1)], out: [of('b6'), of('a3')], start: [of('b0'), of('b9')],
};

export class Pads {
  /** @param {(text: string) => void} say */
  constructor(say) {
    this.say = say;
    /** @type {Map<string, Seen>} */
    this.seen = new Map();
    this.chosen = '';
    this.assigning = false;  // then none drives
  }

  /** All that are there, by number and id. @returns {Map<string, Gamepad>} */
  there() {
    const pads = [...navigator.getGamepads?.() ?? []].filter((pad) => pad?.connected);
    return new Map(pads.map((pad) => [`${pad?.index} ${pad?.id}`, /** @type {Gamepad} */ (pad)]));
  }

  /** @returns {Gamepad | null} */
  own() {
    const there = this.there();
    for (const name of this.seen.keys()) if (!there.has(name)) this.seen.delete(name);
    if (!there.has(this.chosen)) this.chosen = '';
    for (const [name, pad] of there) this.look(name, pad);
    return this.assigning ? null : there.get(this.chosen) ?? null;
  }

  /** @param {string} name @param {Gamepad} pad */
  look(name, pad) {
    const seen = this.seen.get(name) ?? {layout: layoutOf(pad), rested: new Set(), strange: false};
    this.seen.set(name, seen);
    const rests = new Map(Object.values(seen.layout ?? {}).flat().map(({input, rest}) => [input, rest]));
    let moved = false;
    for (const [input, x] of readings(pad)) {
      const away = Math.abs(x - (rests.get(input) ?? 0));
      if (away < kRest) seen.rested.add(input);
      moved ||= away > kMoved && seen.rested.has(input);
    }
    if (!moved || this.chosen || this.assigning) return;
    if (seen.layout) this.chosen = name;
    else if (!seen.strange) this.say(`The gamepad ${called(pad)} is not used: this browser does not know its layout. Press Gamepad to assign it.`);
    seen.strange ||= !seen.layout;
  }

  /** Whether there is one for the person to assign, or to assign again. */
  get assignable() {
    return [...this.seen].some(([name, {strange, layout}]) => strange || (name === this.chosen && layout !== kStandard));
  }

  /** It drives from now on, and in later windows. @param {string} name @param {Gamepad} pad @param {Layout} layout */
  assign(name, pad, layout) {
    this.seen.set(name, {layout, rested: new Set(), strange: false});
    this.chosen = name;
    // By host: the window has another port, and so another storage, each time.
    document.cookie = `${kCookie}${encodeURIComponent(pad.id)}=${encodeURIComponent(JSON.stringify(layout))}; path=/; max-age=34000000; samesite=strict`;
  }

  /** How far it is moved that way, 0 to 1, by what has been at rest. @param {Gamepad} pad @param {Way} way @param {(x: number, input: string) => number} shape */
  share(pad, way, shape = (x) => x) {
    const seen = this.seen.get(this.chosen), now = readings(pad);
    const shares = (seen?.layout?.[way] ?? []).filter(({input}) => seen?.rested.has(input))
        .map(({input, rest, full}) => shape(Math.max(0, Math.min(1, ((now.get(input) ?? rest) - rest) / (full - rest))), input));
    return Math.max(0, ...shares);
  }
}

/** What each axis and button reads. @param {Gamepad} pad @returns {Map<string, number>} */
export function readings(pad) {
  return new Map([...pad.axes.map((x, i) => /** @type {const} */ ([`a${i}`, x])), ...pad.buttons.map(({value}, i) => /** @type {const} */ ([`b${i}`, value]))]);
}

/** @param {Gamepad} pad */
export const called = (pad) => `"${pad.id.slice(0, 60)}"`;

/** @param {Gamepad} pad */
export const standard = (pad) => pad.mapping === 'standard';

/** @param {Gamepad} pad @returns {Layout | null} */
function layoutOf(pad) {
  if (standard(pad)) return kStandard;
  const key = `${kCookie}${encodeURIComponent(pad.id)}=`;
  try {
    const kept = document.cookie.split('; ').find((cookie) => cookie.startsWith(key));
    const layout = kept ? JSON.parse(decodeURIComponent(kept.slice(key.length))) : null;
    const whole = Object.values(layout).flat().every(({input, rest, full}) => typeof input === 'string' && Math.abs(full - rest) > kRest);
    return whole ? layout : null;
  } catch {  // nothing, or not this program's
    return null;
  }
}
