// A person's episodes: start, stop, rate, their list with its learning curve, and
// what is learned from them.
import {byId, element, fixed, withMicro, words} from './format.js';
import {svgElement} from './map.js';

/** @typedef {import('./live.js').Message} Message
 * @typedef {{file: string, outcome: string, score: number | null, trainee?: string, date?: string}} Episode */

export class Session {
  /** @param {(message: Message) => void} send */
  constructor(send) {
    this.send = send;
    this.running = false;
    this.said = false;  // that it is inserted
    this.start = byId('start', HTMLButtonElement);
    this.discard = byId('discard', HTMLButtonElement);
    this.state = byId('session-state', HTMLElement);
    this.ended = byId('ended', HTMLElement);
    this.rating = byId('rating', HTMLFieldSetElement);
    this.list = byId('episodes', HTMLTableSectionElement);
    this.curve = byId('curve', HTMLElement);
    this.fit = byId('fit', HTMLButtonElement);
    this.insert = byId('insert', HTMLButtonElement);
    this.progress = byId('fit-progress', HTMLProgressElement);
    this.fitText = byId('fit-text', HTMLElement);
    /** @type {Set<string>} */
    this.left = new Set();
    /** @type {Episode[]} */
    this.episodes = [];
    this.start.addEventListener('click', () => this.toggle());
    this.discard.addEventListener('click', () => send({type: 'discard'}));
    for (const star of this.rating.querySelectorAll('input'))
      star.addEventListener('change', () => send({type: 'rate', stars: Number(star.value)}));
    this.fit.addEventListener('click', () =>
      send({type: 'fit', episodes: this.episodes.filter((e) => !this.left.has(e.file)).map((e) => e.file)}));
    this.insert.addEventListener('click', () => send({type: 'insert'}));
  }

  /** The fibre is as deep as was asked for: the person says when it is enough. */
  seated() {
    if (this.running && !this.said) this.state.textContent = 'inserted: press Stop (Enter)';
    this.said = true;
  }

  toggle() {
    this.send({type: this.running ? 'stop' : 'start'});
  }

  /** @param {Message} message @returns {boolean} whether it was for this */
  take(message) {
    switch (message.type) {
      case 'state_of_session': return this.stateOf(message);
      case 'ended': return this.end(message);
      case 'episodes': return this.show(/** @type {Episode[]} */ (message.list));
      case 'fit': return this.fitting(message);
      default: return false;
    }
  }

  /** @param {Message} message */
  stateOf(message) {
    const was = this.running;
    this.running = message.running === true;
    this.start.textContent = this.running ? 'Stop' : 'Start';
    this.start.dataset.running = String(this.running);
    this.insert.disabled = message.can_insert !== true;
    this.rating.hidden = message.can_rate !== true;
    const trial = message.trial === undefined ? '' : `, start ${String(message.trial)}`;
    this.state.textContent = !this.running ? `ready: press Start (Enter)${trial}`
      : message.what === 'insert' ? `the learned controller inserts${trial}` : `your try${trial}`;
    if (this.running && !was) {
      this.said = false;
      this.ended.hidden = true;
      for (const star of this.rating.querySelectorAll('input')) star.checked = false;
    }
    return true;
  }

  /** @param {Message} message */
  end(message) {
    const score = /** @type {{total?: number, parts?: Record<string, number | null>} | null} */ (message.score ?? null);
    const who = message.what === 'insert' ? 'the controller: ' : '';
    const took = typeof message.time_s === 'number' ? `, ${fixed(message.time_s, 1)}\u00a0s` : '';
    const peak = typeof message.peak_force_uN === 'number' ? `, at most ${fixed(message.peak_force_uN, 1)}\u00a0\u00b5N` : '';
    this.ended.replaceChildren(element('strong', `${who}${words(String(message.outcome))}${took}${peak}`));
    if (message.why) this.ended.append(element('span', withMicro(String(message.why))));
    if (score && typeof score.total === 'number') {
      this.ended.append(element('span', `score ${fixed(score.total, 1)} of 100`, 'score'));
      const parts = Object.entries(score.parts ?? {}).filter(([, value]) => typeof value === 'number');
      if (parts.length) this.ended.append(element('span', parts.map(([name, value]) => `${words(name)} ${fixed(100 * Number(value), 0)}`).join(' \u00b7 '), 'parts'));
    }
    if (message.hint) this.ended.append(element('span', withMicro(String(message.hint)), 'hint'));
    this.ended.dataset.good = String(message.outcome === 'inserted');
    this.ended.hidden = false;
    return true;
  }

  /** @param {Episode[]} episodes */
  show(episodes) {
    this.episodes = Array.isArray(episodes) ? episodes : [];
    this.list.replaceChildren(...this.episodes.map((episode) => {
      const line = element('tr'), box = element('input'), cell = element('td'), name = element('th', episode.file.replace(/^.*\//, '').replace(/\.h5$/, ''));
      box.type = 'checkbox';
      box.checked = !this.left.has(episode.file);
      box.setAttribute('aria-label', `fit from ${episode.file}`);
      box.addEventListener('change', () => {
        if (box.checked) this.left.delete(episode.file);
        else this.left.add(episode.file);
        this.enable();
      });
      cell.append(box);
      name.scope = 'row';
      name.title = [episode.trainee, episode.date?.replace('T', ' ')].filter(Boolean).join(', ');
      line.append(cell, name, element('td', words(episode.outcome)), element('td', episode.score === null || episode.score === undefined ? '\u2013' : fixed(episode.score, 1)));
      return line;
    }));
    this.drawCurve();
    this.enable();
    return true;
  }

  enable() {
    this.fit.disabled = !this.episodes.some((e) => e.outcome === 'inserted' && !this.left.has(e.file));
  }

  drawCurve() {
    const scores = this.episodes.map((e) => e.score).filter((s) => typeof s === 'number');
    this.curve.hidden = scores.length < 2;
    if (scores.length < 2) return;
    const width = 240, height = 80, left = 24;
    const x = (/** @type {number} */ i) => left + 6 + i * (width - left - 12) / (scores.length - 1);
    const y = (/** @type {number} */ s) => height - 14 - s * (height - 22) / 100;
    const svg = svgElement('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img', 'aria-label': `learning curve: scores ${scores.map((s) => fixed(Number(s), 0)).join(', ')}`});
    svg.append(svgElement('path', {class: 'grid', d: `M${left} ${y(0)}H${width}M${left} ${y(50)}H${width}M${left} ${y(100)}H${width}`}));
    for (const mark of [0, 50, 100]) {
      const text = svgElement('text', {x: String(left - 3), y: String(y(mark) + 3), 'text-anchor': 'end'});
      text.textContent = String(mark);
      svg.append(text);
    }
    const label = svgElement('text', {x: String((width + left) / 2), y: String(height - 2), 'text-anchor': 'middle'});
    label.textContent = 'score by episode';
    svg.append(label, svgElement('path', {class: 'curve', d: scores.map((s, i) => `${i ? 'L' : 'M'}${x(i).toFixed(1)} ${y(Number(s)).toFixed(1)}`).join('')}));
    scores.forEach((s, i) => svg.append(svgElement('circle', {class: 'point', cx: x(i).toFixed(1), cy: y(Number(s)).toFixed(1), r: '2.4'})));
    this.curve.replaceChildren(svg);
  }

  /** @param {Message} message */
  fitting(message) {
    this.progress.hidden = message.state !== 'running';
    this.progress.value = Number(message.progress) || 0;
    this.fitText.textContent = String(message.text ?? '') || (message.state === 'running' ? `fitting, part ${Number(message.part) || 1}` : String(message.state));
    this.fit.disabled = message.state === 'running';
    if (message.state !== 'running') this.enable();
    return true;
  }
}
