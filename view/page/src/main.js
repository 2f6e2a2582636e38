// The page: live where the program serves it, a replay where it has something recorded.
import {Assignment} from './assignment.js';
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
import {detectSoftware, software} from './software.js';
import {SolidView} from './solid_view.js';
import {Sound} from './sound.js';
import {Strips} from './strips.js';
import {colours, watchTheme} from './theme.js';

/** @typedef {import('./recording.js').Scene} Scene @typedef {import('./recording.js').RecordedJson} RecordedJson
 * @typedef {import('./table.js').Read} Read */

const kStripSeconds = 8;
const kStripPeriod = 100;  // between pictures of the strips while they run [ms]; of software twice that
const kSolidPeriods = [66, 400];  // and of 3-D where software renders it, as it can
const kLate = 30;          // a picture that comes so long after the one before is late
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
    this.solid = null;
    this.strips = new Strips(byId('strip-velocity', HTMLElement), byId('strip-force', HTMLElement), (t) => this.replay?.seek(t), () => this.replay !== null);
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
    this.batch = -1;   // of history that the strips show
    /** @type {(() => void) | null} draws the strips of a replay */
    this.restrip = null;
    this.solidDrawn = 0;
    this.solidPeriod = kSolidPeriods[0];
    this.late = {pictures: 0, any: false};  // since 3-D was drawn
    /** @type {{read: Read, other: Read | null} | null} what 3-D does not show yet */
    this.solidDue = null;
    this.rumbled = 0;
    this.before = performance.now();
    this.frames = {count: 0, since: performance.now(), rate: NaN, states: NaN};
    this.drawn = {first: 0, solid: 0};  // when there was something to see [ms since the page was asked for]
    const say = (/** @type {string} */ text) => { byId('said', HTMLElement).textContent = text; };
    this.hand = new Hand(() => this.live?.open === true, () => this.live?.hand(this.hand.velocity()), say);
    this.assignment = new Assignment(this.hand.pads, say);
    this.wire();
  }

  // After the first picture of the rest: it waits for nothing.
  makeSolid() {
    try {
      detectSoftware();
      this.solid = new SolidView(byId('solid', HTMLCanvasElement), byId('solid-note', HTMLElement), () => this.redraw());
      if (this.scene) this.solid.build(this.scene, this.colours);
      this.redraw();
    } catch (error) {
      byId('solid-note', HTMLElement).textContent = 'This browser has no WebGL 2: the other views show the same insertion.';
    }
  }

  wire() {
    const retheme = () => {
      this.colours = colours();
      if (this.scene) this.solid?.build(this.scene, this.colours);
      this.buildStrips();
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
    byId('camera', HTMLButtonElement).addEventListener('click', () => this.nextCamera());
    for (const button of document.querySelectorAll('[data-view]'))
      if (button instanceof HTMLElement) button.addEventListener('click', () => this.only(button.dataset.view ?? null));
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
    addEventListener('resize', () => this.buildStrips());
    addEventListener('keydown', (event) => this.key(event));
    for (const what of ['pointermove', 'wheel', 'keydown']) document.addEventListener(what, () => this.redraw(), {passive: true});
    this.hand.dragIn(byId('side', HTMLCanvasElement), [1, 0, 0], () => this.side.up === 'y' ? [0, 1, 0] : [0, 0, 1]);
    this.hand.dragIn(byId('axis', HTMLCanvasElement), [0, 0, -1], () => [0, 1, 0]);
  }

  nextCamera() {
    const name = this.solid?.nextCamera();
    if (name) byId('camera', HTMLButtonElement).textContent = name;
    this.redraw();
  }

  /** One view alone, or all of them. @param {string | null} view */
  only(view) {
    const main = /** @type {HTMLElement} */ (document.querySelector('main'));
    if (view === null || main.dataset.only === view) delete main.dataset.only;
    else main.dataset.only = view;
    for (const button of document.querySelectorAll('[data-view]'))
      if (button instanceof HTMLElement) button.setAttribute('aria-pressed', String(button.dataset.view === main.dataset.only));
    this.buildStrips();
  }

  nextBend() {
    this.bend = kBends[(kBends.indexOf(this.bend) + 1) % kBends.length];
    byId('bend', HTMLButtonElement).textContent = `bending \u00d7${this.bend}`;
    this.redraw();
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    if (typing(event) || event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector('dialog[open]')) return;  // Escape closes it
    const onButton = event.target instanceof HTMLButtonElement;
    switch (event.key) {
      case 'b': this.nextBend(); break;
      case 'v': this.nextCamera(); break;
      case 'Escape': this.only(null); break;
      case 'r': if (!this.replay) return; this.replay.repeat(); break;
      case '-': this.replay?.faster(-1); break;
      case '+': case '=': this.replay?.faster(1); break;
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

  get stripPeriod() {
    return software ? 2 * kStripPeriod : kStripPeriod;
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
      this.readout.build(scene, phases, () => this.redraw());
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
    this.restrip = strips;
    const replay = this.replay = new Replay(recorded, strips);
    const maps = recorded.maps ?? [];
    byId('tab-map', HTMLElement).hidden = maps.length === 0;
    if (maps.length) new FailureMap((point, map) => void replay.watch(point, map)).set(maps);
    if (maps.length) choose(byId('tab-map', HTMLElement));
    if (this.replay.runs.length) void this.replay.begin(!matchMedia('(prefers-reduced-motion: reduce)').matches);
    else this.replay.say('There is nothing recorded here.');
  }

  /** @param {Worker} link @param {import('./recording.js').FirstPicture | null} picture where there is one before it answers */
  startLive(link, picture) {
    document.body.dataset.mode = 'live';
    choose(byId('tab-session', HTMLElement));
    const live = this.live = new Live({
      hello: (hello) => {
        this.phases = hello.phases;
        this.use(hello.scene, hello.phases);
        document.title = `ferrule: ${hello.scene.name}`;
        session.folder = hello.folder;
        session.shipped(hello);
      },
      message: (message) => {
        if (message.type === 'ended' && session.running) {
          live.hold();
          choose(byId('tab-session', HTMLElement));
        }
        if (message.type === 'state_of_session' && message.running === true && !session.running) {
          live.release();
          choose(byId('tab-terms', HTMLElement));
        }
        if (message.type === 'state_of_session' && message.scene) this.use(/** @type {Scene} */ (message.scene), this.phases);
        if (session.take(message)) return;
        if (message.type === 'error') byId('said', HTMLElement).textContent = String(message.text);
      },
      connected: (is, code) => {
        if (is) byId('said', HTMLElement).textContent = '';
        else this.hand.letGo();
        session.connected(is, code);
      },
    }, link);
    const session = this.session = new Session((message) => live.send(message));
    if (picture) live.begin(picture);
    // Not with the pictures: where they are slow the hand is not silent.
    setInterval(() => {
      this.assignment.look();
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
    this.pace(1e3 * elapsed);
    this.drawSolid(now);
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
    if (replay.playing && now - this.stripped < this.stripPeriod) return;
    this.stripped = now;
    this.strips.resize();
    this.strips.point(replay.t);
  }

  /** @param {number} now */
  frameLive(now) {
    const live = this.live;
    if (!live) return;
    if (!live.newest?.rows || !live.history) return;
    const read = live.newest.read(0), signature = `live ${live.arrived}`;
    if (signature !== this.signature) {
      this.signature = signature;
      this.draw(read, null);
      const {heard} = live;
      afterPicture(() => live.drawn(heard));
    }
    if (this.phases[read('phase')] === 'seated' && read('t_s') > 0) this.session?.seated();
    if (now - this.rumbled > 60) {
      this.rumbled = now;
      this.hand.rumble(touching(read) ? read('force_uN') / read('limit_uN') : 0);
    }
    if (now - this.stripped < this.stripPeriod || !live.history.rows || live.batches === this.batch) return;
    this.stripped = now;
    this.batch = live.batches;
    const [, last] = live.history.span();
    this.strips.resize();
    this.strips.show(live.history, null, live.history.rowAt(last - kStripSeconds), [Math.max(0, last - kStripSeconds), Math.max(kStripSeconds, last)]);
  }

  /** @param {Read} read @param {Read | null} other */
  draw(read, other) {
    if (!this.scene) return;
    this.solidDue = {read, other};
    this.side.draw(this.scene, read, other, this.sideAcross, this.bend, this.colours);
    this.axis.draw(this.scene, read, other, this.axisAcross, this.colours);
    this.readout.draw(read);
    if (this.drawn.first === 0) this.first();
    this.sound.follow(read('force_uN') / read('limit_uN'), touching(read));
  }

  buildStrips() {
    if (this.drawn.first === 0) return;  // they come after it
    this.strips.build(this.colours);
    this.batch = -1;
    this.restrip?.();
    this.redraw();
  }

  /** 3-D is drawn less often while pictures are late after it. @param {number} since the picture before [ms] */
  pace(since) {
    const {late} = this, [least, most] = kSolidPeriods;
    late.any ||= since > kLate;
    if (++late.pictures === 3) this.solidPeriod = Math.max(least, Math.min(most, (late.any ? 1.3 : 0.95) * this.solidPeriod));
  }

  /** 3-D, at its own pace. @param {number} now */
  drawSolid(now) {
    if (!this.solid || !this.solidDue || (software && now - this.solidDrawn < this.solidPeriod)) return;
    this.solidDrawn = now;
    this.late = {pictures: 0, any: false};
    if (this.solid.draw(this.solidDue.read, this.solidDue.other, this.bend)) this.drawn.solid ||= performance.now();
    this.solidDue = null;
  }

  // There is a picture: what takes longer comes after it is on the screen.
  first() {
    this.drawn.first = performance.now();
    requestAnimationFrame(() => setTimeout(() => {
      this.buildStrips();
      setTimeout(() => this.makeSolid());
    }));
  }

  /** Pictures and states a second, and latency, where they are asked for. @param {number} now */
  count(now) {
    ++this.frames.count;
    if (now - this.frames.since < 1000) return;
    const seconds = (now - this.frames.since) / 1e3;
    this.frames.rate = this.frames.count / seconds;
    const states = this.frames.states = this.live ? this.live.states / seconds : NaN;
    this.frames.count = 0;
    this.frames.since = now;
    if (this.live) this.live.states = 0;
    const text = `${fixed(this.frames.rate, 0)} pictures/s` + (this.live ? `, ${fixed(states, 0)} states/s, hand to picture ${fixed(this.live.medianLatency(), 0)} ms (median of ${this.live.latencies.length})` : '');
    byId('health', HTMLElement).textContent = `${text}; first picture after ${fixed(this.drawn.first, 0)} ms`;
  }
}

/** @param {Read} read */
function touching(read) {
  return read('contact0_on') > 0.5 || read('contact1_on') > 0.5;
}

/** When the picture that is being drawn is on the screen. @param {() => void} then */
function afterPicture(then) {
  const {port1, port2} = new MessageChannel();
  port1.onmessage = () => {
    port1.close();
    then();
  };
  port2.postMessage(null);
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
  const recorded = embedded();
  // The program answers while the page is put together.
  const mode = recorded === 'served' ? recorded : recorded?.mode;
  const connects = mode === 'live' && location.protocol.startsWith('http');
  const link = connects || mode === 'playground' ? Live.link(connects) : null;
  const page = new Page();
  Object.assign(globalThis, {ferrule: page});  // for a console
  if (recorded === 'served') {
    const answer = await fetch('recorded');
    if (answer.ok) page.startReplay(await answer.json());
    else byId('said', HTMLElement).textContent = await answer.text();
  } else if (recorded?.mode === 'live') {
    if (link) page.startLive(link, recorded);
    else byId('said', HTMLElement).textContent = 'This page shows a program that runs, and was saved: nothing is recorded in it.';
  } else if (recorded?.mode === 'playground') {
    if (link) page.startLive(link, null);
  } else if (recorded) page.startReplay(recorded);
  else byId('said', HTMLElement).textContent = 'This file holds no recording.';
  page.frame(performance.now());
}

void main();
