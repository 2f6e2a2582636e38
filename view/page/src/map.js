// Where the trials of a campaign started and how they ended; a failed one can be watched.
import {byId, element, words} from './format.js';

/** @typedef {import('./recording.js').MapJson} MapJson @typedef {import('./recording.js').MapPoint} MapPoint */

const kSvg = 'http://www.w3.org/2000/svg';
const kSize = 300, kRoom = 34;
const kReach = 8;  // of a mark, for the mouse

/** How an outcome is drawn: colour and shape, so that either is enough. @type {Record<string, [string, (r: number) => string]>} */
const kMarks = {
  inserted: ['--good', (r) => `M${-0.5 * r} 0a${0.5 * r} ${0.5 * r} 0 1 0 ${r} 0a${0.5 * r} ${0.5 * r} 0 1 0 ${-r} 0`],
  force_limit: ['--alarm', (r) => `M${-r} ${-r}L${r} ${r}M${-r} ${r}L${r} ${-r}`],
  jam: ['--wall', (r) => `M${-r} ${r}L0 ${-r}L${r} ${r}Z`],
  missed: ['--friction', (r) => `M${-r} ${-r}H${r}V${r}H${-r}Z`],
  timeout: ['--drag', (r) => `M0 ${-1.3 * r}L${r} 0L0 ${1.3 * r}L${-r} 0Z`],
};
const kOtherMark = /** @type {[string, (r: number) => string]} */ (['--hand', (r) => `M${-r} 0H${r}M0 ${-r}V${r}`]);

export class FailureMap {
  /** @param {(point: MapPoint, map: MapJson) => void} watch */
  constructor(watch) {
    this.watch = watch;
    this.place = byId('map', HTMLElement);
    this.choice = byId('map-choice', HTMLSelectElement);
    this.trials = byId('map-trials', HTMLSelectElement);
    this.said = byId('map-said', HTMLElement);
    /** @type {MapJson[]} */
    this.maps = [];
    this.choice.addEventListener('change', () => this.show(Number(this.choice.value)));
    this.trials.addEventListener('change', () => this.pick(Number(this.trials.value)));
  }

  /** @param {MapJson[]} maps */
  set(maps) {
    this.maps = maps;
    this.choice.replaceChildren(...maps.map((map, i) => new Option(map.title, String(i))));
    this.choice.hidden = maps.length < 2;
    if (maps.length) this.show(0);
  }

  /** @param {number} which */
  show(which) {
    const map = this.shown = this.maps[which];
    const failed = map.points.filter((p) => p.outcome !== 'inserted' && p.outcome !== 'infeasible');
    this.said.textContent = `${map.title}: ${failed.length} of ${map.points.length} trials failed. Click a mark, or choose:`;
    const unchosen = new Option('a failed trial \u2026', '');
    this.trials.replaceChildren(unchosen, ...failed.map((p) =>
        new Option(`trial ${p.trial}: ${words(p.outcome)}${p.run === undefined ? ' (not in this file)' : ''}`, String(p.trial))));
    this.place.replaceChildren(this.drawing(map), this.legend(map));
  }

  /** @param {MapJson} map */
  drawing(map) {
    const svg = svgElement('svg', {viewBox: `0 0 ${kSize} ${kSize}`, role: 'img', 'aria-label': `${map.title}: outcome of every trial against where it started; the list beside it does the same by keyboard`});
    const far = 1.05 * Math.max(1, ...map.points.map((p) => Math.max(Math.abs(p.y_um), Math.abs(p.z_um))));
    const unit = (kSize / 2 - kRoom) / far;
    const at = (/** @type {MapPoint} */ p) => `translate(${(kSize / 2 - p.z_um * unit).toFixed(1)} ${(kSize / 2 - p.y_um * unit).toFixed(1)})`;
    const low = kRoom, high = kSize - kRoom, middle = kSize / 2;
    svg.append(
        svgElement('path', {class: 'grid', d: `M${low} ${middle}H${high}M${middle} ${low}V${high}M${low} ${low}H${high}V${high}H${low}Z`}),
        text(middle, kSize - 8, 'start z [\u00b5m], to the left'), text(12, middle, 'start y [\u00b5m]', -90),
        text(high, kSize - 21, `\u2212${Math.round(far)}`), text(low, kSize - 21, `${Math.round(far)}`), text(low - 12, low + 4, `${Math.round(far)}`));
    const small = map.points.length > 250 ? 2.6 : 4;
    for (const p of map.points) {
      if (p.outcome === 'infeasible') continue;
      const [colour, shape] = kMarks[p.outcome] ?? kOtherMark;
      const failed = p.outcome !== 'inserted';
      const mark = svgElement('path', {d: shape(small), transform: at(p), class: failed ? 'failed' : 'done', stroke: `var(${colour})`, fill: failed ? 'none' : `var(${colour})`});
      mark.dataset.trial = String(p.trial);
      if (p.run === undefined && map.command) mark.classList.add('absent');
      const reach = svgElement('circle', {r: String(kReach), transform: at(p), class: 'reach'});
      reach.dataset.trial = String(p.trial);
      const title = svgElement('title', {});
      title.textContent = `trial ${p.trial}: ${words(p.outcome)}`;
      reach.append(title);
      svg.append(mark, reach);
    }
    svg.addEventListener('click', (event) => {
      const matrix = svg.getScreenCTM();
      if (!matrix) return;
      // The nearest one: where they are dense they lie over each other. A failed one before others.
      const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      const off = (/** @type {MapPoint} */ p) => Math.hypot(kSize / 2 - p.z_um * unit - place.x, kSize / 2 - p.y_um * unit - place.y) + (p.outcome === 'inserted' ? kReach / 2 : 0);
      const near = map.points.filter((p) => p.outcome !== 'infeasible' && off(p) < kReach).sort((a, b) => off(a) - off(b));
      if (near.length) this.pick(near[0].trial);
    });
    return svg;
  }

  /** @param {MapJson} map */
  legend(map) {
    const list = element('ul', undefined, 'legend');
    for (const outcome of new Set(map.points.map((p) => p.outcome))) {
      const [colour, shape] = kMarks[outcome] ?? kOtherMark;
      const mark = svgElement('svg', {viewBox: '-6 -6 12 12', 'aria-hidden': 'true'});
      mark.append(svgElement('path', {d: shape(4), stroke: `var(${colour})`, fill: outcome === 'inserted' ? `var(${colour})` : 'none'}));
      const item = element('li');
      item.append(mark, `${words(outcome)} (${map.points.filter((p) => p.outcome === outcome).length})`);
      list.append(item);
    }
    return list;
  }

  /** @param {number} trial */
  pick(trial) {
    const point = this.shown?.points.find((p) => p.trial === trial);
    if (!point || !this.shown) return;
    for (const mark of this.place.querySelectorAll('.chosen')) mark.classList.remove('chosen');
    this.place.querySelector(`path[data-trial="${trial}"]`)?.classList.add('chosen');
    this.trials.value = point.outcome === 'inserted' ? '' : String(trial);
    this.watch(point, this.shown);
  }
}

/** @template {keyof SVGElementTagNameMap} K @param {K} tag @param {Record<string, string>} attributes @returns {SVGElementTagNameMap[K]} */
export function svgElement(tag, attributes) {
  const made = document.createElementNS(kSvg, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

/** @param {number} x @param {number} y @param {string} label @param {number} [turn] */
function text(x, y, label, turn = 0) {
  const made = svgElement('text', {x: String(x), y: String(y), 'text-anchor': 'middle', ...(turn ? {transform: `rotate(${turn} ${x} ${y})`} : {})});
  made.textContent = label;
  return made;
}
