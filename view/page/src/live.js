// The running program: rows come, the hand's velocity and requests go, by way of a worker (link.js).
import {byId} from './format.js';
import {Table} from './table.js';

/** @typedef {import('./recording.js').Scene} Scene
 * @typedef {{type: 'hello', protocol: number, scene: Scene, columns: string[], phases: string[], devices: string[], mode: string, folder: string,
 *   scenes?: string[], controllers?: string[]}} Hello
 * @typedef {Record<string, unknown> & {type: string}} Message */

const kProtocol = 1;
const kKeepSeconds = 30;
const kHold = 3000;     // how an insertion ended is shown so long, before the next start [ms]
const kMostMessage = 4096;  // bytes; the program ends the connection above them (view/message.hpp)
const kSilent = 40;     // between words of a hand at rest [ms]: the program stops one that is silent for 200

export class Live {
  /** @param {{hello: (hello: Hello) => void, message: (message: Message) => void, connected: (is: boolean, code: number) => void}} on @param {Worker} link */
  constructor(on, link) {
    this.on = on;
    this.link = link;
    this.open = true;  // until it is known to be closed
    /** @type {Table | null} the last rows at 1 kHz */
    this.history = null;
    /** @type {Table | null} the newest row */
    this.newest = null;
    this.running = false;
    this.begins = false;  // an insertion, none of whose rows was heard
    this.seq = 0;
    /** @type {Map<number, number>} when a word of the hand was sent [ms] */
    this.sent = new Map();
    this.heard = 0;    // word of the hand that the newest row has heard
    /** @type {number[]} hand to picture [ms], the last ones */
    this.latencies = [];
    /** @type {ArrayBuffer | null} the newest row, while an older one is shown */
    this.held = null;
    /** @type {ReturnType<typeof setTimeout> | undefined} */
    this.releasing = undefined;
    this.states = 0;   // since they were counted
    this.arrived = 0;  // in all
    this.batches = 0;
    this.said = 0;
    link.onmessage = ({data}) => {
      if (typeof data === 'string') this.take(JSON.parse(data));
      else if (data instanceof ArrayBuffer) this.rows(data);
      else this.connected(data.connected, data.code);
    };
  }

  /** Who answers the page, a worker: it connects to the program that served it, or has the simulator in itself. @param {boolean} connects */
  static link(connects) {
    const script = new Blob([byId('link', HTMLScriptElement).text], {type: 'text/javascript'});
    const link = new Worker(URL.createObjectURL(script));
    if (!connects) return link;
    const here = new URL('live', location.href);
    here.protocol = 'ws:';
    here.hash = '';
    link.postMessage({address: here.href});
    return link;
  }

  /** @param {boolean} is @param {number} code of its end */
  connected(is, code) {
    this.open = is;
    this.on.connected(is, code);
  }

  /** @param {Message} message */
  take(message) {
    if (message.type === 'state_of_session') {
      const running = message.running === true;
      this.begins ||= running && !this.running;
      this.running = running;
    }
    if (message.type !== 'hello') return this.on.message(message);
    const hello = /** @type {Hello} */ (/** @type {unknown} */ (message));
    if (hello.protocol !== kProtocol) return this.on.message({type: 'error', text: 'this page is of another version of the program: load it again'});
    this.history = new Table(hello.columns, 1000 * kKeepSeconds);
    this.newest = new Table(hello.columns, 1);
    this.on.hello(hello);
  }

  /** @param {ArrayBuffer} packet u32 kind, rows, columns, seq; float32 rows */
  rows(packet) {
    if (!this.history || !this.newest || packet.byteLength < 16) return;
    const [kind, rows, columns, seq] = new Uint32Array(packet, 0, 4);
    if (columns !== this.history.columns.length || packet.byteLength < 16 + 4 * rows * columns || rows === 0) return;
    const data = new Float32Array(packet, 16, rows * columns);
    if (kind === 1 && this.held) {
      this.held = packet;
      return;
    }
    if (kind === 2) {
      if (!this.running && rows === 1 && data[0] === 0) return;  // at rest, before a try: the strips keep the last one
      if (this.begins) this.history.clear();
      this.begins = false;
      // What a page is greeted with may come again in the next batch.
      const [, last] = this.history.span();
      let known = 0;
      while (this.history.rows && known < rows && data[known * columns] <= last) ++known;
      this.history.append(data.subarray(known * columns));
      ++this.batches;
    } else if (kind === 1) {
      this.newest.clear();
      this.newest.append(data.subarray((rows - 1) * columns));
      this.heard = seq;
      ++this.states;
      ++this.arrived;
    }
  }

  /** What the page came with. @param {import('./recording.js').FirstPicture} picture */
  begin(picture) {
    this.take(picture.hello);
    this.take(picture.state);
    this.newest?.append(Float32Array.from(picture.frame, (x) => x ?? NaN));
    ++this.arrived;
  }

  /** For a while the newest row stays what it is. */
  hold() {
    this.held = new ArrayBuffer(0);
    clearTimeout(this.releasing);
    this.releasing = setTimeout(() => this.release(), kHold);
  }

  release() {
    const held = this.held;
    this.held = null;
    clearTimeout(this.releasing);
    if (held) this.rows(held);
  }

  /** @param {Message} message */
  send(message) {
    const text = JSON.stringify(message), {length} = new TextEncoder().encode(text);
    if (length <= kMostMessage) this.link.postMessage({text});
    else this.on.message({type: 'error', text: `too much at once for the program (${length} bytes of ${kMostMessage}): choose fewer episodes, or all but a few`});
  }

  /** @param {[number, number, number]} v */
  hand(v) {
    const now = performance.now();
    const active = v.some((x) => x !== 0);
    if (!this.open) return;
    if (!active && now - this.said < kSilent) return;
    this.said = now;
    ++this.seq;
    this.sent.set(this.seq, now);
    this.sent.delete(this.seq - 600);
    const hand = {type: 'hand', v: v.map((x) => Math.round(x * 1e4) / 1e4), buttons: 0, seq: this.seq, t: Math.round(now)};
    this.link.postMessage({hand: JSON.stringify(hand), moves: active});
  }

  /** A row is on the screen, that has heard the hand's word `heard`. @param {number} heard */
  drawn(heard) {
    const sent = this.sent.get(heard);
    if (sent === undefined) return;
    this.latencies.push(performance.now() - sent);
    if (this.latencies.length > 240) this.latencies.shift();
    for (const seq of this.sent.keys()) if (seq <= heard) this.sent.delete(seq);
  }

  /** [ms] */
  medianLatency() {
    const sorted = [...this.latencies].sort((a, b) => a - b);
    return sorted.length ? sorted[sorted.length >> 1] : NaN;
  }
}
