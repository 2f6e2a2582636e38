// The page: live where the program serves it, a replay where it has something recorded.
import {AxisView} from './axis_view.js';
import {byId, fixed} from './format.js';
import {Hand, typing} from './hand.js';
import {Live} from './live.js';
import {Magnification} from './magnify.js';
import {FailureMap} from './map.js';
import {Readout} from './readout.js';
import {embedded} from './recording.js';
import {Replay} from './replay.js';
import {Session} from './session.js';
import {SideView} from './side_view.js';
import {software} from './software.js';
import {SolidView} from './solid_view.js';
import {Sound} from './sound.js';
import {Strips} from './strips.js';
import {colours, watchTheme} from './theme.js';

/** @typedef {import('./recording.js').Scene} Scene @typedef {import('./recording.js').RecordedJson} RecordedJson
 * @typedef {import('./table.js').Read} Read */

const kStripSeconds = 8;
const kStripPeriod = software ? 200 : 100;  // between pictures of the strips while they run [ms]
const kSolidPeriod = 66;   // and of 3-D where software renders it
const kHandPeriod = 16;    // between words of the hand [ms]
const kBends = [1, 10, 100, 1000];

class Page {
  constructor() {
    this.readout = new Readout();
    this.sideAcross = new Magnification();
    this.axisAcross = new Magnification();
    this.side = new SideView(byId('side', HTMLCanvasElement));
    this.axis = new AxisView(byId('axis', HTMLCanvasElement));
    /** @type {SolidView | null} */
    this.solid = this.makeSolid();
    this.strips = new Strips(byId('strip-velocity', HTMLElement), byId('strip-force', HTMLElement), (t) => this.replay?.seek(t));
    this.sound = new Sound();
    /** @type {Replay | null} */
    this.replay = null;
    /** @type {Live | null} */
    this.live = null;
    /** @type {Session | null} */
    this.session = null;
    /** @type {Scene | null} */
    this.scene = null;
    /** @type {string[]} */
    this.phases = [];
    this.colours = colours();
    this.bend = 1;
    this.signature = '';
    this.stripped = 0;
    this.solidDrawn = 0;
    this.rumbled = 0;
    this.before = performance.now();
    this.frames = {count: 0, since: performance.now(), rate: NaN};
    this.hand = new Hand(() => this.live !== null);
    this.wire();
  }

  makeSolid() {
    try {
      return new SolidView(byId('solid', HTMLCanvasElement), byId('solid-note', HTMLElement));
    } catch (error) {
      byId('solid-note', HTMLElement).textContent = 'This browser has no WebGL 2: the other views show the same insertion.';
      return null;
    }
  }

  wire() {
    const retheme = () => {
      this.colours = colours();
      if (this.scene) this.solid?.build(this.scene, this.colours);
      this.strips.build(this.colours);
      this.redraw();
    };
    const toggle = watchTheme(retheme);
    byId('theme', HTMLButtonElement).addEventListener('click', toggle);
    const soundButton = byId('sound', HTMLButtonElement);
    soundButton.addEventListener('click', () => soundButton.setAttribute('aria-pressed', String(this.sound.toggle())));
    const health = byId('health', HTMLElement), healthButton = byId('health-toggle', HTMLButtonElement);
    healthButton.addEventListener('click', () => {
      health.hidden = !health.hidden;
      healthButton.setAttribute('aria-expanded', String(!health.hidden));
    });
    const help = byId('help', HTMLDialogElement);
    byId('help-open', HTMLButtonElement).addEventListener('click', () => help.showModal());
    byId('bend', HTMLButtonElement).addEventListener('click', () => this.nextBend());
    byId('plane', HTMLButtonElement).addEventListener('click', (event) => {
      this.side.up = this.side.up === 'y' ? 'z' : 'y';
      /** @type {HTMLElement} */ (event.currentTarget).textContent = this.side.up === 'y' ? 'x\u2013y' : 'x\u2013z';
      this.redraw();
    });
    byId('true-scale', HTMLButtonElement).addEventListener('click', (event) => {
      const on = !this.sideAcross.trueScale;
      this.sideAcross.trueScale = this.axisAcross.trueScale = on;
      this.sideAcross.range = this.axisAcross.range = 0;
      /** @type {HTMLElement} */ (event.currentTarget).setAttribute('aria-pressed', String(on));
      this.redraw();
    });
    for (const tab of document.querySelectorAll('[role=tab]'))
      if (tab instanceof HTMLElement) {
        tab.addEventListener('click', () => choose(tab));
        tab.addEventListener('keydown', (event) => {
          const all = [...document.querySelectorAll('[role=tab]')].filter((t) => t instanceof HTMLElement && !t.hidden);
          const next = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
          if (next === 0) return;
          event.preventDefault();
          const to = all[(all.indexOf(tab) + next + all.length) % all.length];
          if (to instanceof HTMLElement) { choose(to); to.focus(); }
        });
      }
    addEventListener('resize', () => {
      this.strips.build(this.colours);
      this.redraw();
    });
    addEventListener('keydown', (event) => this.key(event));
    for (const what of ['pointermove', 'wheel', 'keydown']) document.addEventListener(what, () => this.redraw(), {passive: true});
    this.hand.dragIn(byId('side', HTMLCanvasElement), [1, 0, 0], () => this.side.up === 'y' ? [0, 1, 0] : [0, 0, 1]);
    this.hand.dragIn(byId('axis', HTMLCanvasElement), [0, 0, -1], () => [0, 1, 0]);
  }

  nextBend() {
    this.bend = kBends[(kBends.indexOf(this.bend) + 1) % kBends.length];
    byId('bend', HTMLButtonElement).textContent = `bending \u00d7${this.bend}`;
    this.redraw();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (typing(event.target) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector('dialog[open]')) return;
    const onButton = event.target instanceof HTMLButtonElement;
    switch (event.key) {
      case 'b': this.nextBend(); break;
      case 't': byId('theme', HTMLButtonElement).click(); break;
      case 'm': byId('sound', HTMLButtonElement).click(); break;
      case 'l': byId('health-toggle', HTMLButtonElement).click(); break;
      case '?': byId('help-open', HTMLButtonElement).click(); break;
      case ' ': if (onButton || !this.replay) return; this.replay.toggle(); break;
      case 'Enter': if (onButton || !this.session) return; this.session.toggle(); break;
      case '[': this.replay?.jump(-1); break;
      case ']': this.replay?.jump(1); break;
      case ',': this.replay?.step(-1); break;
      case '.': this.replay?.step(1); break;
      case 'ArrowLeft': case 'ArrowRight':
        if (!this.replay) return;
        this.replay.seek(this.replay.t + (event.key === 'ArrowLeft' ? -1 : 1) * (event.shiftKey ? 1 : 0.1));
        break;
      default: return;
    }
    event.preventDefault();
  }

  /** Whether another picture follows at once. */
  get moving() {
    return this.live !== null || this.replay?.playing === true;
  }

  redraw() {
    this.signature = '';
  }

  /** @param {Scene} scene @param {string[]} phases */
  use(scene, phases) {
    if (JSON.stringify(this.scene) !== JSON.stringify(scene)) {
      this.scene = scene;
      byId('scene', HTMLElement).textContent = `scene ${scene.name}`;
      byId('scene', HTMLElement).title = scene.about;
      byId('bend', HTMLButtonElement).hidden = !(scene.geometry.free_length_um > 0);
      this.readout.build(scene, phases);
      this.sideAcross.range = this.axisAcross.range = 0;
      this.solid?.build(scene, this.colours);
    }
    this.redraw();
  }

  /** @param {RecordedJson} recorded */
  startReplay(recorded) {
    document.body.dataset.mode = 'replay';
    document.title = recorded.title ? `ferrule: ${recorded.title}` : 'ferrule: replay';
    const strips = () => {
      if (!this.replay) return;
      const {shown, over} = this.replay;
      this.use(shown.scene, recorded.phases);
      const [first, last] = shown.table.span();
      this.strips.show(shown.table, over ? over.table : null, 0, [first, Math.max(last, over ? over.table.span()[1] : last)]);
    };
    this.strips.build(this.colours);
    const replay = this.replay = new Replay(recorded, strips);
    const maps = recorded.maps ?? [];
    byId('tab-map', HTMLElement).hidden = maps.length === 0;
    if (maps.length) new FailureMap((point, map) => void replay.watch(point, map)).set(maps);
    if (maps.length) choose(byId('tab-map', HTMLElement));
    addEventListener('resize', strips);
    byId('theme', HTMLButtonElement).addEventListener('click', strips);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', strips);
    if (this.replay.runs.length) {
      void this.replay.show(this.replay.runs[0], !matchMedia('(prefers-reduced-motion: reduce)').matches);
      if (recorded.over !== undefined && this.replay.runs[recorded.over]) void this.replay.lay(this.replay.runs[recorded.over]);
    }
    else this.replay.say('There is nothing recorded here.');
  }

  startLive() {
    document.body.dataset.mode = 'live';
    this.strips.build(this.colours);
    choose(byId('tab-session', HTMLElement));
    const live = this.live = new Live({
      hello: (hello) => {
        this.phases = hello.phases;
        this.use(hello.scene, hello.phases);
        document.title = `ferrule: ${hello.scene.name}`;
      },
      message: (message) => {
        if (message.type === 'state_of_session' && message.scene) this.use(/** @type {Scene} */ (message.scene), this.phases);
        if (session.take(message)) return;
        if (message.type === 'error') byId('said', HTMLElement).textContent = String(message.text);
      },
      connected: (is) => {
        byId('connection', HTMLElement).textContent = is ? 'connected' : 'not connected: trying again';
        byId('connection', HTMLElement).dataset.good = String(is);
        if (is) byId('said', HTMLElement).textContent = '';
      },
    });
    const session = this.session = new Session((message) => live.send(message));
    // Not with the pictures: where they are slow the hand is not silent.
    setInterval(() => {
      if (this.hand.started()) session.toggle();
      live.hand(this.hand.velocity());
    }, kHandPeriod);
  }

  /** @param {number} now */
  frame(now) {
    const elapsed = Math.min(0.25, (now - this.before) / 1e3);
    this.before = now;
    if (this.replay) this.frameReplay(elapsed);
    else if (this.live) this.frameLive(now);
    this.count(now);
    requestAnimationFrame((next) => this.frame(next));
  }

  /** @param {number} elapsed [s] */
  frameReplay(elapsed) {
    const replay = this.replay;
    if (!replay || !replay.shown?.loaded) return;
    replay.advance(elapsed);
    const {table} = replay.shown, row = replay.row;
    const other = replay.over?.loaded ? replay.over.table : null;
    const signature = `${replay.runs.indexOf(replay.shown)}:${row}:${replay.playing}:${replay.over ? replay.runs.indexOf(replay.over) : ''}`;
    if (signature === this.signature) return;
    this.signature = signature;
    this.draw(table.read(row), other ? other.read(other.rowAt(replay.t)) : null);
    const now = performance.now();
    if (replay.playing && now - this.stripped < kStripPeriod) return;
    this.stripped = now;
    this.strips.resize();
    this.strips.point(replay.t);
  }

  /** @param {number} now */
  frameLive(now) {
    const live = this.live;
    if (!live) return;
    if (!live.newest?.rows || !live.history) return;
    const read = live.newest.read(0);
    this.draw(read, null);
    live.drawn();
    if (this.phases[read('phase')] === 'seated' && read('t_s') > 0) this.session?.seated();
    if (now - this.rumbled > 60) {
      this.rumbled = now;
      this.hand.rumble(touching(read) ? read('force_uN') / read('limit_uN') : 0);
    }
    if (now - this.stripped < kStripPeriod || !live.history.rows) return;
    this.stripped = now;
    const [, last] = live.history.span();
    this.strips.resize();
    this.strips.show(live.history, null, live.history.rowAt(last - kStripSeconds), [last - kStripSeconds, last]);
  }

  /** @param {Read} read @param {Read | null} other */
  draw(read, other) {
    if (!this.scene) return;
    const now = performance.now();
    if (this.solid && (!software || now - this.solidDrawn >= kSolidPeriod || !this.moving)) {
      this.solidDrawn = now;
      this.solid.draw(read, other, this.bend);
    }
    this.side.draw(this.scene, read, other, this.sideAcross, this.bend, this.colours);
    this.axis.draw(this.scene, read, other, this.axisAcross, this.colours);
    this.readout.draw(read);
    this.sound.follow(read('force_uN') / read('limit_uN'), touching(read));
  }

  /** Pictures and states a second, and latency, where they are asked for. @param {number} now */
  count(now) {
    ++this.frames.count;
    if (now - this.frames.since < 1000) return;
    const seconds = (now - this.frames.since) / 1e3;
    this.frames.rate = this.frames.count / seconds;
    const states = this.live ? this.live.states / seconds : NaN;
    this.frames.count = 0;
    this.frames.since = now;
    if (this.live) this.live.states = 0;
    const text = `${fixed(this.frames.rate, 0)} pictures/s` + (this.live ? `, ${fixed(states, 0)} states/s, hand to picture ${fixed(this.live.medianLatency(), 0)} ms (median of ${this.live.latencies.length})` : '');
    byId('health', HTMLElement).textContent = text;
  }
}

/** @param {Read} read */
function touching(read) {
  return read('contact0_on') > 0.5 || read('contact1_on') > 0.5;
}

/** Shows the panel of a tab. @param {HTMLElement} tab */
function choose(tab) {
  for (const each of document.querySelectorAll('[role=tab]')) {
    const on = each === tab;
    each.setAttribute('aria-selected', String(on));
    each.setAttribute('tabindex', on ? '0' : '-1');
    const panel = document.getElementById(each.getAttribute('aria-controls') ?? '');
    if (panel) panel.hidden = !on;
  }
}

async function main() {
  const page = new Page();
  Object.assign(globalThis, {ferrule: page});  // for a console
  const recorded = embedded();
  if (recorded === 'served') {
    const answer = await fetch('recorded');
    if (answer.ok) page.startReplay(await answer.json());
    else byId('said', HTMLElement).textContent = await answer.text();
  } else if (recorded) page.startReplay(recorded);
  else if (location.protocol.startsWith('http')) page.startLive();
  else byId('said', HTMLElement).textContent = 'This file holds no recording.';
  page.frame(performance.now());
}

void main();
