// The magnification across the axis, the same from the side and along the axis: displacements are
// drawn `scale` pixels a micrometre, and the fibre's radius no larger than fits, so that what is
// left of the pane is play.
import {atMouth} from './shape.js';

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene */

export class Magnification {
  constructor() {
    this.scale = 0;    // of displacements and gaps [pixels/um]
    this.radius = 0;   // of the fibre [pixels]
    this.factor = 1;   // scale against that of the radius: 1 is true
    this.trueScale = false;
    this.range = 0;    // displacement that fits [um]
  }

  /**
   * @param {Scene} scene @param {Read[]} reads what must fit @param {number} half of the pane [pixels]
   */
  fit(scene, reads, half) {
    const {fibre_radius_um: radius, bore_radius_um: bore} = scene.geometry;
    const room = 0.94 * half;
    if (this.trueScale) {
      this.scale = room / (2 * radius);
      this.radius = this.scale * radius;
      this.factor = 1;
      this.range = 0;
      return;
    }
    let needed = bore - radius;
    for (const read of reads) {
      const mouth = atMouth(read);
      needed = Math.max(needed, Math.hypot(read('tip_y_um'), read('tip_z_um')), Math.hypot(mouth.y, mouth.z));
    }
    needed *= 1.15;
    // In steps, and with a reserve before it magnifies again: the picture holds still.
    const step = 10 ** (Math.ceil(10 * Math.log10(needed)) / 10);
    if (!(this.range >= needed) || step * 1.9 < this.range) this.range = step;
    this.radius = Math.min(room * radius / (radius + this.range), 0.38 * room);
    this.scale = (room - this.radius) / this.range;
    this.factor = this.scale * radius / this.radius;
  }

  text() {
    const factor = this.factor < 9.95 ? this.factor.toFixed(1) : String(Math.round(this.factor));
    return this.factor < 1.05 ? 'true scale' : `gaps \u00d7${factor}`;
  }
}
