// Asks the person for the sticks and buttons of a gamepad whose layout the browser does not know.
// Each is moved all the way and let go: where it is then is its rest, as a browser may not know where
// a trigger rests before it was moved.
import {byId} from './format.js';
import {called, kMoved, readings, standard} from './pads.js';

/** @typedef {import('./pads.js').Control} Control @typedef {import('./pads.js').Way} Way
 * @typedef {{base: Map<string, number>, peaks: Map<string, number>, now: Map<string, number>, still: number}} Watched
 *   what it read when it was asked for, farthest from there, and now; since when that is the same [ms] */

/** @type {{way: Way, back?: Way, text: string}[]} */
const kSteps = [
  {way: 'right', back: 'left', text: 'Move the stick that is to move the fibre sideways all the way to the right, and let go.'},
  {way: 'up', back: 'down', text: 'Move the same stick all the way up, and let go.'},
  {way: 'in', text: 'Press the trigger or button that is to push in all the way, and let go. Or move another stick.'},
  {way: 'out', text: 'Press the one that is to pull out all the way, and let go.'},
  {way: 'start', text: 'Press the button that is to start and stop a try, and let go.'},
];
const kSame = 0.05;    // readings within this are the same
const kStill = 300;    // what is the same for so long was let go, if it was moved [ms]
const kStuck = 3000;   // and was held when it was asked for, if nothing was let go: it counts from there

export class Assignment {
  /** @param {import('./pads.js').Pads} pads @param {(text: string) => void} say */
  constructor(pads, say) {
    this.pads = pads;
    this.say = say;
    this.dialog = byId('assign', HTMLDialogElement);
    this.button = byId('assign-open', HTMLButtonElement);
    this.text = byId('assign-step', HTMLElement);
    this.note = byId('assign-note', HTMLElement);
    this.name = '';  // of the gamepad, once it was moved
    this.step = 0;
    /** @type {import('./pads.js').Layout} */
    this.layout = {};
    /** @type {Map<string, Watched>} */
    this.watched = new Map();
    this.button.addEventListener('click', () => this.begin());
    byId('assign-skip', HTMLButtonElement).addEventListener('click', () => this.next());
    this.dialog.addEventListener('close', () => { this.pads.assigning = false; });
  }

  begin() {
    this.pads.assigning = true;
    this.name = '';
    this.layout = {};
    this.step = -1;
    this.next();
    this.dialog.showModal();
  }

  /** The next question, or the end. */
  next() {
    const pad = this.pads.there().get(this.name);
    if (++this.step < kSteps.length) return this.ask('');
    this.end();
    if (!pad) return;
    this.pads.assign(this.name, pad, this.layout);
    this.say(`The gamepad ${called(pad)} drives. Press Gamepad to assign it again.`);
  }

  /** At once: the dialog says that it is closed only after the next pictures. */
  end() {
    this.pads.assigning = false;
    this.dialog.close();
  }

  /** @param {string} note */
  ask(note) {
    this.watched.clear();
    this.text.textContent = `${this.step + 1} of ${kSteps.length}: ${kSteps[this.step].text}`;
    this.note.textContent = note;
  }

  /** Looks at what is moved, and offers this where it is needed. */
  look() {
    this.button.hidden = !this.pads.assignable;
    if (!this.pads.assigning) return;
    const there = this.pads.there();
    if (this.name && !there.has(this.name)) {
      this.say('The gamepad is gone.');
      return this.end();
    }
    for (const [name, pad] of there)
      if (!standard(pad) && (this.name || name) === name) {
        const control = this.released(name, readings(pad));
        if (control) return this.take(name, control);
      }
  }

  /** What was moved and let go. @param {string} name @param {Map<string, number>} read @returns {Control | null} */
  released(name, read) {
    const now = performance.now(), seen = this.watched.get(name);
    const differs = (/** @type {Map<string, number>} */ from) => [...read].some(([input, x]) => Math.abs(x - (from.get(input) ?? x)) > kSame);
    if (!seen || differs(seen.now)) {
      const {base, peaks} = seen ?? {base: read, peaks: new Map(read)};
      for (const [input, x] of read) {
        const from = base.get(input) ?? x, peak = peaks.get(input) ?? x;
        if (Math.abs(x - from) > Math.abs(peak - from) + kSame) peaks.set(input, x);
      }
      this.watched.set(name, {base, peaks, now: read, still: now});
      return null;
    }
    if (now - seen.still < kStill) return null;
    if (now - seen.still > kStuck) this.watched.delete(name);
    const way = (/** @type {string} */ input) => Math.abs((seen.peaks.get(input) ?? 0) - (read.get(input) ?? 0));
    // A hat rests beyond 1, and says eight ways in one number.
    const [input] = [...read.keys()].filter((each) => Math.abs(read.get(each) ?? 0) <= 1 + kSame).sort((a, b) => way(b) - way(a));
    const rounded = (/** @type {Map<string, number>} */ of) => Math.round(1e3 * (of.get(input) ?? 0)) / 1e3;
    return input && way(input) > kMoved ? {input, rest: rounded(read), full: rounded(seen.peaks)} : null;
  }

  /** @param {string} name @param {Control} control */
  take(name, control) {
    const {way, back} = kSteps[this.step], {input, rest, full} = control;
    if (back && input.startsWith('b')) return this.ask('That was a button: this has to be a stick.');
    const opposite = (/** @type {Control} */ other) => other.input === input && (other.full > other.rest) !== (full > rest);
    const taken = Object.values(this.layout).flat().some((other) => other.input === input && (back !== undefined || !opposite(other)));
    if (taken) return this.ask('That does something else already.');
    this.name = name;
    this.layout[way] = [control];
    if (back) this.layout[back] = [{input, rest, full: 2 * rest - full}];
    this.next();
  }
}
