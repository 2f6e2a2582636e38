// A person's episodes: who it is, start, stop, rate, their list with its learning curve, and
// what is learned from them.
import {byId, element, fixed, withMicro, words} from './format.js';
import {drawCurves, person, Persons} from './persons.js';

/** @typedef {import('./live.js').Message} Message @typedef {import('./persons.js').Episode} Episode */

const kRest = 700;         // a press so soon after the end was meant to stop, and starts nothing [ms]
const kGoingAway = 1001;   // the program ended in order

export class Session {
  /** @param {(message: Message) => void} send */
  constructor(send) {
    this.send = send;
    this.running = false;
    this.trying = false;  // a person holds the fibre, or nobody
    this.said = false;    // that it is inserted
    this.online = true;   // until it is known to be otherwise
    this.rests = false;
    this.fits = false;
    this.canInsert = false;
    this.goesOn = false;  // after the goal
    this.folder = '';
    this.saved = '';      // file of the last try
    this.name = '';       // of the person
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
    this.save = byId('save', HTMLButtonElement);
    this.scenes = byId('scene-choice', HTMLSelectElement);
    this.controllers = byId('controller-choice', HTMLSelectElement);
    this.within = false;  // the page has the simulator in itself
    this.connection = byId('connection', HTMLElement);
    this.gone = byId('gone', HTMLElement);
    this.who = byId('who', HTMLElement);
    this.trainee = byId('trainee', HTMLInputElement);
    this.trainees = byId('trainees', HTMLDataListElement);
    this.persons = new Persons();
    /** @type {Set<string>} */
    this.left = new Set();
    /** @type {Episode[]} */
    this.episodes = [];
    this.start.addEventListener('click', () => this.toggle());
    this.discard.addEventListener('click', () => send({type: 'discard'}));
    for (const star of this.rating.querySelectorAll('input'))
      star.addEventListener('change', () => send({type: 'rate', stars: Number(star.value)}));
    this.fit.addEventListener('click', () => send(this.chosen()));
    this.insert.addEventListener('click', () => send(this.within ? {type: 'insert', controller: this.controllers.value} : {type: 'insert'}));
    this.save.addEventListener('click', () => send({type: 'save', file: this.saved}));
    this.scenes.addEventListener('change', () => {
      send({type: 'scene', name: this.scenes.value});
      this.scenes.blur();
    });
    this.controllers.addEventListener('change', () => this.controllers.blur());
    this.trainee.addEventListener('change', () => {
      send({type: 'trainee', name: this.trainee.value.trim()});
      this.trainee.blur();
    });
  }

  /** What there is to choose from where the page has the simulator in itself. @param {import('./live.js').Hello} hello */
  shipped({scene, scenes, controllers}) {
    if (!scenes || !controllers) return;
    this.within = true;
    this.connection.hidden = this.fit.hidden = true;
    this.save.hidden = this.scenes.hidden = this.controllers.hidden = false;
    this.scenes.replaceChildren(...scenes.map((name) => new Option(name, name, false, name === scene.name)));
    this.controllers.replaceChildren(...controllers.map((name) => new Option(words(name), name)));
    this.ended.hidden = true;
  }

  /** @param {boolean} is @param {number} code of its end */
  connected(is, code) {
    if (!is && !this.online) return;  // said already
    this.online = is;
    this.connection.textContent = is ? 'connected' : code === kGoingAway ? 'the program has ended' : 'not connected: trying again';
    this.connection.dataset.good = String(is);
    this.gone.hidden = is;
    if (!is) this.gone.textContent = this.farewell(code === kGoingAway);
    this.state.hidden = !is;
    this.enable();
  }

  /** What is known of the tries of a program that is gone. @param {boolean} inOrder */
  farewell(inOrder) {
    const list = this.episodes.length ? ` Your tries are saved in ${this.folder}.` : '';
    if (!inOrder && this.trying) return `The program does not answer. If it was killed, your try is not lost: ferrule recover ${this.folder} brings it back.${list}`;
    if (!inOrder) return `The program does not answer.${list}`;
    const last = this.episodes.some((e) => e.file === this.saved) ? ` Your last try is saved as ${this.folder}/${this.saved}.` : list;
    return `The program has ended.${last}`;
  }

  /** The fibre is as deep as was asked for: that ends the try, or the person says when it is enough. */
  seated() {
    if (this.running && !this.said) this.state.textContent = this.goesOn ? 'inserted: press Stop (Enter)' : 'inserted';
    this.said = true;
  }

  toggle() {
    if (!this.start.disabled) this.send({type: this.running ? 'stop' : 'start'});
  }

  /** @param {Message} message @returns {boolean} whether it was for this */
  take(message) {
    switch (message.type) {
      case 'state_of_session': return this.stateOf(message);
      case 'ended': return this.end(message);
      case 'episodes': return this.show(/** @type {Episode[]} */ (message.list));
      case 'fit': return this.fitting(message);
      case 'log': return this.keep(String(message.file), String(message.text));
      default: return false;
    }
  }

  /** @param {Message} message */
  stateOf(message) {
    const was = this.running;
    this.running = message.running === true;
    this.start.textContent = this.running ? 'Stop' : 'Start';
    this.start.dataset.running = String(this.running);
    this.trying = this.running && message.what === 'try';
    this.canInsert = message.can_insert === true;
    this.goesOn = message.goes_on === true;
    this.who.textContent = String(message.trainee ?? '');
    this.name = this.who.textContent || String(message.device ?? '');
    if (document.activeElement !== this.trainee) this.trainee.value = this.who.textContent;
    this.rating.hidden = message.can_rate !== true;
    const trial = message.trial === undefined ? '' : `, start ${String(message.trial)}`;
    this.state.textContent = !this.running ? `ready: press Start (Enter)${trial}`
      : message.what === 'insert' ? `the learned controller inserts${trial}` : `your try${trial}`;
    if (this.running && !was) {
      this.said = false;
      this.ended.hidden = true;
      this.saved = '';
      for (const star of this.rating.querySelectorAll('input')) star.checked = false;
    }
    this.drawCurve();
    this.enable();
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
    this.trying = false;
    if (message.file) this.saved = String(message.file);
    this.rests = this.running;  // not where a page that is loaded hears of the last one
    setTimeout(() => {
      this.rests = false;
      this.enable();
    }, kRest);
    this.enable();
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
    const names = new Set(this.episodes.map((e) => e.trainee ?? '').filter(Boolean));
    this.trainees.replaceChildren(...[...names].map((name) => new Option(name)));
    this.persons.show(this.episodes);
    this.drawCurve();
    this.enable();
    return true;
  }

  /** The message that fits from what is ticked, as short as it can be. @returns {Message} */
  chosen() {
    const here = this.episodes.filter((e) => e.same_scene);
    const names = (/** @type {boolean} */ left) => here.filter((e) => this.left.has(e.file) === left).map((e) => e.file);
    const episodes = names(false), but = names(true);
    return but.length === 0 ? {type: 'fit'} : but.length < episodes.length ? {type: 'fit', but} : {type: 'fit', episodes};
  }

  /** A try as a file. @param {string} file @param {string} text */
  keep(file, text) {
    const link = element('a');
    link.href = URL.createObjectURL(new Blob([text], {type: 'application/json'}));
    link.download = file;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    byId('said', HTMLElement).textContent = `ferrule import ${file} --out episodes makes an episode of it`;
    return true;
  }

  /** What can be asked of the program now. */
  enable() {
    this.start.disabled = !this.online || this.rests;
    this.discard.disabled = this.rating.disabled = !this.online;
    this.trainee.disabled = !this.online || this.running;
    this.insert.disabled = !this.online || !this.canInsert;
    this.save.disabled = this.running || !this.episodes.some((e) => e.file === this.saved);
    this.scenes.disabled = this.running;
    this.fit.disabled = !this.online || this.fits || !this.episodes.some((e) => e.same_scene && e.outcome === 'inserted' && !this.left.has(e.file));
  }

  drawCurve() {
    const scores = this.episodes.filter((e) => e.same_scene && person(e) === this.name).map((e) => e.score).filter((s) => typeof s === 'number');
    this.curve.hidden = scores.length < 2;
    if (!this.curve.hidden) this.curve.replaceChildren(drawCurves([{name: this.name, scores}], 80));
  }

  /** @param {Message} message */
  fitting(message) {
    this.progress.hidden = message.state !== 'running';
    this.progress.value = Number(message.progress) || 0;
    this.fitText.textContent = String(message.text ?? '') || (message.state === 'running' ? `fitting, part ${Number(message.part) || 1}` : String(message.state));
    this.fits = message.state === 'running';
    this.enable();
    return true;
  }
}
