// Replay: what is shown, when, how fast; two runs over each other; jumps to events.
import {byId, element, fixed, words} from './format.js';
import {RecordedRun} from './recording.js';

/** @typedef {import('./recording.js').RecordedJson} RecordedJson @typedef {import('./recording.js').Event} Event
 * @typedef {import('./recording.js').RunJson} RunJson @typedef {import('./recording.js').MapPoint} MapPoint
 * @typedef {import('./recording.js').MapJson} MapJson */

export class Replay {
  /** @param {RecordedJson} recorded @param {() => void} changed  another run is shown */
  constructor(recorded, changed) {
    this.recorded = recorded;
    this.changed = changed;
    this.runs = recorded.runs.map((run) => new RecordedRun(run, recorded.columns, recorded.scene));
    this.shown = this.runs[0];
    /** @type {RecordedRun | null} */
    this.over = null;
    this.t = 0;
    this.speed = 1;
    this.playing = false;
    this.play = byId('play', HTMLButtonElement);
    this.scrub = byId('scrub', HTMLInputElement);
    this.clock = byId('clock', HTMLElement);
    this.choice = byId('run', HTMLSelectElement);
    this.overChoice = byId('over', HTMLSelectElement);
    this.events = byId('events', HTMLElement);
    this.ticks = byId('ticks', HTMLElement);
    this.outcome = byId('outcome', HTMLElement);
    this.said = byId('said', HTMLElement);
    this.wire();
    this.listRuns();
  }

  wire() {
    this.play.addEventListener('click', () => this.toggle());
    this.scrub.addEventListener('input', () => {
      this.playing = false;
      this.seek(Number(this.scrub.value));
    });
    byId('speed', HTMLSelectElement).addEventListener('change', (event) => {
      this.speed = Number(/** @type {HTMLSelectElement} */ (event.target).value);
    });
    byId('event-before', HTMLButtonElement).addEventListener('click', () => this.jump(-1));
    byId('event-after', HTMLButtonElement).addEventListener('click', () => this.jump(1));
    this.choice.addEventListener('change', () => void this.show(this.runs[Number(this.choice.value)]));
    this.overChoice.addEventListener('change', () => void this.lay(this.runs[Number(this.overChoice.value)] ?? null));
  }

  listRuns() {
    const label = (/** @type {RecordedRun} */ run) => run.outcome ? `${run.name}: ${words(run.outcome)}` : run.name;
    this.choice.replaceChildren(...this.runs.map((run, i) => new Option(label(run), String(i))));
    this.overChoice.replaceChildren(new Option('nothing', ''), ...this.runs.map((run, i) => new Option(label(run), String(i))));
    this.choice.value = String(this.runs.indexOf(this.shown));
    this.overChoice.value = this.over ? String(this.runs.indexOf(this.over)) : '';
  }

  /** Rows that are not here yet come from the program. @param {RecordedRun} run */
  async load(run) {
    if (run.loaded || run.file === undefined) return;
    const answer = await fetch(`recorded?file=${encodeURIComponent(run.file)}`);
    if (!answer.ok) throw new Error(`${run.name} could not be read: ${(await answer.text()).slice(0, 200)}`);
    /** @type {RecordedJson} */
    const json = await answer.json();
    Object.assign(run, new RecordedRun(json.runs[0], json.columns, json.scene), {file: run.file});
    this.listRuns();
  }

  /** @param {RecordedRun} run @param {boolean} [play] */
  async show(run, play = false) {
    try {
      await this.load(run);
    } catch (error) {
      this.say(String(error instanceof Error ? error.message : error));
      return;
    }
    this.shown = run;
    this.choice.value = String(this.runs.indexOf(run));
    const [first, last] = run.table.span();
    this.scrub.min = String(first);
    this.scrub.max = String(last);
    this.scrub.step = '0.001';
    this.listEvents();
    this.playing = play;
    this.seek(first);
    this.changed();
  }

  /** @param {RecordedRun | null} run */
  async lay(run) {
    if (run) await this.load(run);
    this.over = run;
    this.overChoice.value = run ? String(this.runs.indexOf(run)) : '';
    this.changed();
  }

  listEvents() {
    const {events, table} = this.shown, [first, last] = table.span();
    this.events.replaceChildren(...events.map((event) => {
      const item = element('li'), button = element('button', `${fixed(event.t_s, 3)} s  ${event.text || event.kind}`);
      button.type = 'button';
      button.addEventListener('click', () => {
        this.playing = false;
        this.seek(event.t_s);
      });
      item.append(button);
      return item;
    }));
    if (!events.length) this.events.append(element('li', 'no events'));
    this.ticks.replaceChildren(...events.map((event) => {
      const tick = element('span');
      tick.style.left = `${100 * (event.t_s - first) / Math.max(1e-9, last - first)}%`;
      tick.dataset.kind = event.kind;
      return tick;
    }));
  }

  /** @param {string} text */
  say(text) {
    this.said.textContent = text;
  }

  get row() {
    return this.shown.table.rowAt(this.t);
  }

  toggle() {
    const [first, last] = this.shown.table.span();
    if (!this.playing && this.t >= last - 1e-6) this.seek(first);
    this.playing = !this.playing;
    this.update();
  }

  /** @param {number} t [s] */
  seek(t) {
    const [first, last] = this.shown.table.span();
    this.t = Math.max(first, Math.min(last, t));
    this.update();
  }

  /** To the row before or after. @param {number} rows */
  step(rows) {
    this.playing = false;
    const table = this.shown.table;
    this.seek(table.at(Math.max(0, Math.min(table.rows - 1, this.row + rows)), 't_s'));
  }

  /** To the event before or after. @param {number} way */
  jump(way) {
    this.playing = false;
    const events = way > 0 ? this.shown.events.filter((e) => e.t_s > this.t + 1e-4) : this.shown.events.filter((e) => e.t_s < this.t - 1e-4).reverse();
    const [first, last] = this.shown.table.span();
    this.seek(events[0]?.t_s ?? (way > 0 ? last : first));
    if (events[0]) this.say(events[0].text || events[0].kind);
  }

  /** @param {number} elapsed [s] */
  advance(elapsed) {
    if (!this.playing) return;
    const [, last] = this.shown.table.span();
    this.t += elapsed * this.speed;
    if (this.t >= last) {
      this.t = last;
      this.playing = false;
    }
    this.update();
  }

  update() {
    const [first, last] = this.shown.table.span();
    const label = this.playing ? 'Pause' : 'Play';
    if (this.play.textContent !== label) this.play.textContent = label;
    this.scrub.value = String(this.t);
    this.scrub.setAttribute('aria-valuetext', `${fixed(this.t, 2)} seconds of ${fixed(last, 2)}`);
    this.clock.textContent = `${fixed(this.t, 3)} / ${fixed(last, 3)} s`;
    const over = this.t >= last - 1e-6 && last > first;
    const text = over ? `ended: ${words(this.shown.outcome)}${this.shown.why ? `. ${this.shown.why}` : ''}` : '';
    if (this.outcome.textContent !== text) this.outcome.textContent = text;
    this.outcome.hidden = !over;
    this.outcome.dataset.good = String(this.shown.outcome === 'inserted');
  }

  /** A trial of the map. @param {MapPoint} point @param {MapJson} map */
  async watch(point, map) {
    if (point.run === undefined || !this.runs[point.run]) {
      this.say(`Trial ${point.trial} (${words(point.outcome)}) is not in this file. It is made again by: ${map.command.replace('TRIAL', String(point.trial))}`);
      return;
    }
    const run = this.runs[point.run];
    this.say(`Trial ${point.trial}: ${words(point.outcome)}${run.why ? `. ${run.why}` : ''}`);
    await this.show(run, true);
  }
}
