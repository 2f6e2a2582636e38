// The sound of contact: a tone that rises with the force. Off until it is asked for.

export class Sound {
  constructor() {
    /** @type {AudioContext | null} */
    this.audio = null;
    /** @type {OscillatorNode | null} */
    this.tone = null;
    /** @type {GainNode | null} */
    this.gain = null;
    this.on = false;
  }

  toggle() {
    this.on = !this.on;
    if (this.on && !this.audio) {
      this.audio = new AudioContext();
      this.tone = new OscillatorNode(this.audio, {type: 'triangle', frequency: 110});
      this.gain = new GainNode(this.audio, {gain: 0});
      this.tone.connect(this.gain).connect(this.audio.destination);
      this.tone.start();
    }
    if (this.on) void this.audio?.resume();
    else void this.audio?.suspend();
    return this.on;
  }

  /** @param {number} share force, of the limit @param {boolean} touching */
  follow(share, touching) {
    if (!this.on || !this.audio || !this.tone || !this.gain) return;
    const now = this.audio.currentTime, loud = touching ? Math.min(1, share) : 0;
    this.tone.frequency.setTargetAtTime(110 * 2 ** (3 * Math.min(1, share)), now, 0.03);
    this.gain.gain.setTargetAtTime(0.25 * Math.sqrt(loud), now, 0.03);
  }
}
