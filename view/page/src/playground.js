// The simulator in the page itself, in a thread of its own (a worker), in the place of a connection to the program
// (link.js): the same words come in, the same texts and frames go out (view/playground/playground.cpp).

export {};

/** @typedef {{ccall: (name: string, result: null, types: string[], values: unknown[]) => void}} Simulator */

const kStep = 4;       // between looks at the clock [ms]
const kAgain = 20;     // a moving hand is said so often at least [ms]: one that is silent for 200 has let go
const kHangs = 300;    // the page, where it is not heard for longer while the hand moves [ms]
const kIdle = 500;     // without a word other than of a hand at rest [ms]

/** @type {Simulator | null} */
let simulator = null;
/** @type {string[]} said before there was one */
const unsaid = [];
/** @type {{text: string, heard: number, said: number} | null} a hand that moves */
let hand = null;
let before = 0, heard = 0;

/** @param {string} text */
function say(text) {
  if (simulator) simulator.ccall('hear', null, ['string'], [text]);
  else unsaid.push(text);
}

onmessage = ({data}) => {
  const now = performance.now();
  if (data.hand) hand = data.moves ? {text: data.hand, heard: now, said: now} : null;
  if (data.text || data.moves) heard = now;
  if (data.hand && simulator) say(data.hand);
  if (data.text) say(data.text);
};

/** @type {(options?: object) => Promise<Simulator>} */
const make = Reflect.get(globalThis, 'makePlayground');

void make().then((made) => {
  simulator = made;
  Object.assign(globalThis, {simulator});  // for a console
  postMessage({connected: true});
  simulator.ccall('begin', null, [], []);
  for (const text of unsaid.splice(0)) say(text);
  before = heard = performance.now();
  setInterval(() => {
    const now = performance.now();
    if (hand && now - hand.said >= kAgain && now - hand.heard <= kHangs) {
      hand.said = now;
      say(hand.text);
    }
    made.ccall('advance', null, ['number'], [(now - before) / 1e3]);
    before = now;
    if (now - heard < kIdle) return;
    made.ccall('idle', null, [], []);
    heard = Infinity;  // until there is another word
  }, kStep);
});
