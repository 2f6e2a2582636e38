// Persons side by side: what their tries in this scene came to, and how their scores go.
import {byId, element, fixed} from './format.js';
import {svgElement} from './map.js';

/** @typedef {{file: string, outcome: string, score: number | null, time_s: number, peak_force_uN: number,
 *   operator: string, trainee?: string, date?: string, same_scene?: boolean}} Episode
 * @typedef {{name: string, tries: number, inserted: number, time: number, force: number, scores: number[], trend: number}} Standing
 *   medians: time of what was inserted [s], largest force [uN]; trend: score a try, NaN of less than three */

const kColours = ['--x', '--y', '--z', '--ghost', '--flow', '--particle'];

/** Whose try it is. @param {Episode} episode */
export function person(episode) {
  return episode.trainee || episode.operator;
}

/** By the tries in this scene, but those that were interrupted. @param {Episode[]} episodes @returns {Standing[]} */
export function standings(episodes) {
  /** @type {Map<string, Episode[]>} */
  const tries = new Map();
  for (const episode of episodes)
    if (episode.same_scene && episode.outcome !== 'interrupted') tries.set(person(episode), [...tries.get(person(episode)) ?? [], episode]);
  return [...tries].map(([name, all]) => {
    const inserted = all.filter((e) => e.outcome === 'inserted');
    const scores = all.map((e) => e.score).filter((s) => typeof s === 'number');
    return {
      name, tries: all.length, inserted: inserted.length, time: median(inserted.map((e) => e.time_s)),
      force: median(all.map((e) => e.peak_force_uN)), scores, trend: slope(scores),
    };
  });
}

/** @param {number[]} numbers */
export function median(numbers) {
  const sorted = [...numbers].sort((a, b) => a - b), middle = sorted.length >> 1;
  return sorted.length === 0 ? NaN : sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}

/** Of the straight line of least squares. @param {number[]} numbers */
function slope(numbers) {
  const n = numbers.length, middle = (n - 1) / 2;
  if (n < 3) return NaN;
  return numbers.reduce((sum, y, i) => sum + (i - middle) * y, 0) / numbers.reduce((sum, _, i) => sum + (i - middle) ** 2, 0);
}

export class Persons {
  constructor() {
    this.table = byId('standings', HTMLTableSectionElement);
    this.curves = byId('curves', HTMLElement);
  }

  /** @param {Episode[]} episodes */
  show(episodes) {
    const all = standings(episodes);
    this.table.replaceChildren(...all.map((of, i) => {
      const line = element('tr'), name = element('th');
      name.scope = 'row';
      name.title = of.name;
      name.append(swatch(i), of.name);
      const trend = (of.trend > 0 ? '+' : '') + fixed(of.trend, 1);
      line.append(name, ...[`${of.inserted}/${of.tries}`, fixed(of.time, 1), fixed(of.force, 1), fixed(median(of.scores), 1), trend].map((text) => element('td', text)));
      return line;
    }));
    const curves = all.filter((of) => of.scores.length > 1);
    this.curves.hidden = curves.length === 0;
    if (curves.length) this.curves.replaceChildren(drawCurves(all, 120));
  }
}

/** The line of a person in the curves. @param {number} i */
function line(i) {
  return {stroke: `var(${kColours[i % kColours.length]})`, 'stroke-dasharray': i < kColours.length ? 'none' : '4 3'};
}

/** @param {number} i */
function swatch(i) {
  const made = svgElement('svg', {viewBox: '0 0 16 8', class: 'swatch', 'aria-hidden': 'true'});
  made.append(svgElement('path', {class: 'curve', d: 'M0 4H16', ...line(i)}));
  return made;
}

/** Scores try by try. @param {{name: string, scores: number[]}[]} persons @param {number} height */
export function drawCurves(persons, height) {
  const width = 240, left = 24, most = Math.max(2, ...persons.map((of) => of.scores.length));
  const x = (/** @type {number} */ i) => left + 6 + i * (width - left - 12) / (most - 1);
  const y = (/** @type {number} */ s) => height - 14 - s * (height - 22) / 100;
  const svg = svgElement('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': persons.map((of) => `scores of ${of.name}: ${of.scores.map((s) => fixed(s, 0)).join(', ')}`).join('; ')});
  svg.append(svgElement('path', {class: 'grid', d: `M${left} ${y(0)}H${width}M${left} ${y(50)}H${width}M${left} ${y(100)}H${width}`}));
  for (const mark of [0, 50, 100]) {
    const text = svgElement('text', {x: String(left - 3), y: String(y(mark) + 3), 'text-anchor': 'end'});
    text.textContent = String(mark);
    svg.append(text);
  }
  const label = svgElement('text', {x: String((width + left) / 2), y: String(height - 2), 'text-anchor': 'middle'});
  label.textContent = 'score by try';
  svg.append(label);
  persons.forEach(({scores}, i) => {
    svg.append(svgElement('path', {class: 'curve', d: scores.map((s, n) => `${n ? 'L' : 'M'}${x(n).toFixed(1)} ${y(s).toFixed(1)}`).join(''), ...line(i)}));
    for (const [n, s] of scores.entries()) svg.append(svgElement('circle', {cx: x(n).toFixed(1), cy: y(s).toFixed(1), r: '2.4', fill: line(i).stroke}));
  });
  return svg;
}
