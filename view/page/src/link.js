// The connection to the program, in a thread of its own (a worker): while the page is busy with its
// pictures, the hand that it held last is said again, so that the program does not take it for one
// that has let go. A page that is not heard for kHangs hangs: then the hand is silent. A page that
// is closed takes this with it.
//
// From the page: {address}: connect; {hand, moves}: a word of the hand, and whether it moves; {text}
// any other message. To it: texts and frames as they come; {connected, code}: a connection, or its
// end with the code of RFC 6455.

export {};

const kAgain = 20;     // a moving hand is said so often at least [ms]: the program stops one that is silent for 200
const kHangs = 300;    // [ms]
const kGoingAway = 1001;
const kFull = 65536;   // bytes that may wait to be sent

let retry = 250;       // [ms]
/** @type {WebSocket | null} */
let socket = null;
/** @type {string[]} said before there was a connection */
let unsent = [];
/** @type {{text: string, heard: number, said: number} | null} a hand that moves */
let hand = null;

/** @param {string} address */
function connect(address) {
  socket = new WebSocket(address);
  socket.binaryType = 'arraybuffer';
  socket.onopen = () => {
    retry = 250;
    postMessage({connected: true});
    for (const text of unsent.splice(0)) send(text);
  };
  socket.onmessage = ({data}) => postMessage(data, typeof data === 'string' ? {} : {transfer: [data]});
  socket.onclose = ({code}) => {
    hand = null;
    postMessage({connected: false, code});
    if (code === kGoingAway) return;
    setTimeout(() => connect(address), retry);
    retry = Math.min(4000, 2 * retry);
  };
}

/** @param {string} text */
function send(text) {
  if (socket?.readyState === WebSocket.OPEN && socket.bufferedAmount < kFull) socket.send(text);
}

onmessage = ({data}) => {
  if (data.address) connect(data.address);
  if (data.hand) {
    const now = performance.now();
    hand = data.moves ? {text: data.hand, heard: now, said: now} : null;
    send(data.hand);
  }
  if (data.text && socket?.readyState === WebSocket.CONNECTING) unsent.push(data.text);
  else if (data.text) send(data.text);
};

setInterval(() => {
  const now = performance.now();
  if (!hand || now - hand.said < kAgain || now - hand.heard > kHangs) return;
  hand.said = now;
  send(hand.text);
}, kAgain / 2);
