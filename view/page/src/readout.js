// The numbers beside the picture: they keep their width, and have units.
import {byId, element, fixed, significant, words} from './format.js';
import {hidden, wayToAxis} from './shape.js';

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene */

/** @type {[string, (read: Read) => string, string, (read: Read) => string][]} key, label, unit, value */
const kNumbers = [
  ['depth', () => 'depth', '\u00b5m', (read) => fixed(read('depth_um'), 2)],
  ['clearance', gapLabel, '\u00b5m', (read) => fixed(Math.abs(read('clearance_um')), 3)],
  ['tilt', () => 'tilt', 'mrad', (read) => fixed(1e3 * read('tilt_rad'), 2)],
  ['speed', () => 'speed', '\u00b5m/s', (read) => fixed(speed(read), 1)],
];

/** What the gap is where it is none: an end outside that would not go in, or a contact. @param {Read} read */
function gapLabel(read) {
  return !(read('clearance_um') < 0) ? 'clearance' : read('depth_um') > 0 ? 'contact, pressed in by' : 'beside the bore by';
}

const kArrows = ['\u2192', '\u2197', '\u2191', '\u2196', '\u2190', '\u2199', '\u2193', '\u2198'];  // every 45 degrees from the right

/** @param {Scene} scene @param {Read} read */
function wayText(scene, read) {
  const way = wayToAxis(scene, read);
  if (!way) return 'on the axis';
  return `${kArrows[(Math.round(Math.atan2(way.up, way.right) / (Math.PI / 4)) + 8) % 8]} ${fixed(way.size, 2)} \u00b5m`;
}

const kPhaseText = /** @type {Record<string, string>} */ ({
  approach: 'approach', face: 'on the face', cone: 'in the cone', in_bore: 'in the bore', one_point: 'one-point contact',
  two_point: 'two-point contact', seated: 'seated', jammed: 'jammed',
});

/** @param {Read} read [um/s] */
export function speed(read) {
  return Math.hypot(read('velocity_x_um_s'), read('velocity_y_um_s'), read('velocity_z_um_s'));
}

export class Readout {
  constructor() {
    this.phase = byId('phase', HTMLElement);
    this.gauge = byId('gauge', HTMLElement);
    this.gaugeFill = byId('gauge-fill', HTMLElement);
    this.gaugeText = byId('gauge-text', HTMLElement);
    this.numbers = kNumbers.map(([key, label, unit, value]) => {
      const row = element('div', undefined, 'number');
      const cell = element('dd', '\u2013');
      cell.id = `value-${key}`;
      const head = element('dt', '\u2013');
      row.append(head, cell, element('dd', unit, 'unit'));
      byId('numbers', HTMLElement).append(row);
      return {head, label, cell, value};
    });
    this.way = byId('way', HTMLElement);
    this.wayText = byId('way-text', HTMLElement);
    this.loss = byId('loss', HTMLElement);
    this.lossOf = byId('loss-of', HTMLElement);
    this.loop = byId('loop', HTMLElement);
    /** @type {{term: string, cells: HTMLElement[]}[]} */
    this.terms = [];
    /** @type {string[]} */
    this.phases = [];
    /** @type {Scene | null} */
    this.scene = null;
  }

  /** @param {Scene} scene @param {string[]} phases @param {() => void} changed  other arrows are wanted */
  build(scene, phases, changed) {
    this.phases = phases;
    this.scene = scene;
    this.way.hidden = scene.cue !== true;
    const body = byId('terms', HTMLTableSectionElement);
    body.replaceChildren();
    const row = (/** @type {string} */ term, /** @type {string} */ label) => {
      const line = element('tr'), head = element('th');
      head.scope = 'row';
      const choice = element('label'), box = element('input');
      box.type = 'checkbox';
      box.checked = !hidden.has(term);
      box.title = 'its arrow, of this colour';
      box.style.accentColor = `var(--${term.replaceAll('_', '-')})`;
      box.style.borderColor = box.style.accentColor;
      box.addEventListener('change', () => {
        if (box.checked) hidden.delete(term);
        else hidden.add(term);
        changed();
      });
      choice.append(box, label);
      head.append(choice);
      const cells = ['x', 'y', 'z'].map(() => element('td', '\u2013'));
      line.append(head, ...cells);
      body.append(line);
      return {term, cells};
    };
    this.terms = scene.terms.map((term) => row(term, words(term)));
    this.terms.push(row('hand', 'at holder'));
  }

  /** @param {Read} read */
  draw(read) {
    for (const {head, label, cell, value} of this.numbers) {
      put(head, label(read));
      put(cell, value(read));
    }
    if (this.scene?.cue) put(this.wayText, wayText(this.scene, read));
    const phase = this.phases[read('phase')] ?? '';
    put(this.phase, kPhaseText[phase] ?? (phase || '\u2013'));
    this.phase.dataset.phase = phase;
    const force = read('force_uN'), limit = read('limit_uN'), share = limit > 0 ? force / limit : 0;
    this.gaugeFill.style.transform = `scaleX(${Math.min(1, share || 0).toFixed(4)})`;
    this.gauge.dataset.level = share > 0.8 ? 'high' : share > 0.5 ? 'middle' : 'low';
    this.gauge.setAttribute('aria-valuenow', (force || 0).toFixed(1));
    this.gauge.setAttribute('aria-valuemax', (limit || 0).toFixed(0));
    this.gauge.setAttribute('aria-valuetext', `${fixed(force, 1)} of ${fixed(limit, 0)} micronewton`);
    put(this.gaugeText, `${fixed(force, 2)} / ${fixed(limit, 0)} \u00b5N`);
    put(this.loss, read('loss_dB') < 99.995 ? fixed(read('loss_dB'), 2) : '> 99');
    put(this.lossOf, `offset ${fixed(read('loss_offset_um'), 2)} \u00b5m, tilt ${fixed(1e3 * read('loss_tilt_rad'), 2)} mrad`);
    for (const {term, cells} of this.terms)
      ['x', 'y', 'z'].forEach((axis, i) => put(cells[i], significant(read(term === 'hand' ? `force_${axis}_uN` : `${term}_${axis}_uN`))));
    const period = read('period_us');
    put(this.loop, period > 0
      ? `${fixed(1e6 / period, 0)} Hz, worst ${fixed(read('worst_period_us') / 1e3, 2)} ms, missed ${fixed(read('missed'), 0)}; hand's energy ${fixed(1e6 * read('passivity_J'), 1)} \u00b5J`
      : 'rests');
  }
}

/** @param {HTMLElement} cell @param {string} text */
function put(cell, text) {
  if (cell.textContent !== text) cell.textContent = text;
}
