// From the side: x to the right (out of the bore), y up; the fibre comes from the right. Along the
// axis to scale; across it magnified as along the axis.
import {axes} from './axis_view.js';
import {length} from './format.js';
import {forceScale, Pane} from './pane.js';
import {contacts, drawnLength, fibreAt, filledWithLiquid, hidden, termForces, wayToAxis} from './shape.js';

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene
 * @typedef {import('./theme.js').Colours} Colours @typedef {import('./magnify.js').Magnification} Magnification */

export class SideView {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.pane = new Pane(canvas);
    /** @type {'y' | 'z'} what is up */
    this.up = 'y';
  }

  /** @param {Scene} scene @param {Read} read @param {Read | null} other @param {Magnification} across @param {number} bend @param {Colours} colours */
  draw(scene, read, other, across, bend, colours) {
    const pane = this.pane;
    if (!pane.begin()) return;
    const {context: c, width, height, rem} = pane;
    const g = scene.geometry;
    const half = 0.5 * height;
    across.fit(scene, other ? [read, other] : [read], half);
    const {scale, radius} = across;
    const low = -1.25 * Math.max(scene.success_depth_um, 0.25 * g.lead_in_length_um, 20);
    const high = 1.3 * Math.max(scene.start.distance_um, g.lead_in_length_um, 20);
    const along = width / (high - low);
    const X = (/** @type {number} */ x) => (x - low) * along;
    const Y = (/** @type {number} */ y) => half - y * scale;
    // A wall `from` the axis: its gap to a fibre in the middle is what is magnified.
    const wall = (/** @type {number} */ from) => radius + (from - g.fibre_radius_um) * scale;

    if (filledWithLiquid(scene)) {
      c.fillStyle = colours.liquid;
      const bore = wall(g.bore_radius_um);
      c.fillRect(0, half - bore, X(0), 2 * bore);
      c.beginPath();  // its meniscus
      c.ellipse(X(0), half, 0.7 * rem, bore, 0, -Math.PI / 2, Math.PI / 2);
      c.fill();
    }
    for (const sign of [1, -1]) {
      const y = (/** @type {number} */ from) => half - sign * wall(from);
      const outside = half - sign * 2 * height;
      c.beginPath();
      c.moveTo(-9, y(g.bore_radius_um));
      c.lineTo(X(0), y(g.bore_radius_um));
      c.lineTo(X(g.lead_in_length_um), y(g.mouth_radius_um));
      c.lineTo(X(g.lead_in_length_um), outside);
      c.lineTo(-9, outside);
      c.closePath();
      c.fillStyle = colours.ferruleCut;
      c.fill();
      c.strokeStyle = colours.ink;
      c.lineWidth = 0.15 * rem;
      c.setLineDash([]);
      c.stroke();
    }
    line(c, 0, half, width, half, colours.soft, [0.8 * rem, 0.3 * rem, 0.1 * rem, 0.3 * rem]);
    const goal = X(-scene.success_depth_um);
    line(c, goal, half - wall(g.bore_radius_um), goal, half + wall(g.bore_radius_um), colours.good, [0.35 * rem, 0.35 * rem]);
    line(c, X(0), half - wall(g.bore_radius_um), X(0), half + wall(g.bore_radius_um), colours.line, []);
    pane.font(0.85);
    pane.text(`goal ${length(scene.success_depth_um)}`, Math.max(goal, 3 * rem), half - wall(g.bore_radius_um) - 0.6 * rem, colours.good, colours.ferruleCut, 'center');

    const outline = (/** @type {Read} */ of, /** @type {number} */ bending) => {
      const steps = 48, most = Math.min(drawnLength(scene), high - of('tip_x_um') + 20);
      /** @type {[number, number][]} */
      const centre = [];
      for (let i = 0; i <= steps; ++i) {
        const at = fibreAt(scene, of, most * i / steps, bending);
        centre.push([X(at[0]), Y(this.up === 'y' ? at[1] : at[2])]);
      }
      c.beginPath();
      for (const [x, y] of centre) c.lineTo(x, y - radius);
      for (const [x, y] of centre.reverse()) c.lineTo(x, y + radius);
      c.closePath();
    };
    if (other) {
      outline(other, bend);
      c.strokeStyle = colours.ghost;
      c.lineWidth = 0.2 * rem;
      c.setLineDash([0.7 * rem, 0.5 * rem]);
      c.stroke();
      c.setLineDash([]);
    }
    outline(read, bend);
    c.globalAlpha = 0.85;
    c.fillStyle = colours.fibre;
    c.fill();
    c.globalAlpha = 1;
    c.strokeStyle = colours.fibreEdge;
    c.lineWidth = 0.18 * rem;
    c.stroke();
    // Where the holder is: a fibre that nothing bends.
    const holder = (/** @type {number} */ s) => Y(read(`holder_${this.up}_um`) + s * read(`holder_a${this.up}_rad`));
    const from = read('holder_x_um'), to = high + 20;
    for (const sign of [1, -1])
      line(c, X(from), holder(0) - sign * radius, X(to), holder(to - from) - sign * radius, colours.hand, [0.5 * rem, 0.4 * rem]);
    line(c, X(from), holder(0) - radius, X(from), holder(0) + radius, colours.hand, [0.5 * rem, 0.4 * rem]);

    const across1 = this.up === 'y' ? 1 : 2;
    const tipX = X(read('tip_x_um')), tipY = Y(read(`tip_${this.up}_um`));
    for (const {at} of contacts(read)) {
      const centre = fibreAt(scene, read, at[0] - read('tip_x_um'), bend);
      const share = (at[across1] - centre[across1]) / g.fibre_radius_um;
      pane.contact(X(at[0]), Y(centre[across1]) - Math.max(-1, Math.min(1, share)) * radius, colours.contact, colours.ground);
    }
    if (read('bridge_on') > 0.5) {
      const sign = read(`tip_${this.up}_um`) >= 0 ? 1 : -1;
      c.fillStyle = colours.liquid;
      c.beginPath();
      c.ellipse(X(Math.max(read('tip_x_um'), 0)), half - sign * 0.5 * (radius + wall(g.bore_radius_um)), 1.2 * rem,
          Math.max(0.3 * rem, 0.5 * (wall(g.bore_radius_um) - radius)), 0, 0, 2 * Math.PI);
      c.fill();
    }
    const force = forceScale(read('limit_uN'), 0.4 * Math.min(width, height));
    for (const {term, force: f, at} of termForces(scene, read)) {
      const x = at[0] === read('tip_x_um') ? tipX : X(at[0]);
      pane.arrow(x, tipY, f[0] * force, -f[across1] * force, colours.terms[term] ?? colours.ink);
    }
    if (!hidden.has('hand')) pane.arrow(tipX, tipY, read('force_x_uN') * force, -read(`force_${this.up}_uN`) * force, colours.hand, 0.3);

    const way = wayToAxis(scene, read), upward = way && (this.up === 'y' ? way.up : -way.right);
    if (upward) pane.cue(tipX, tipY, 0, -upward * scale, Math.abs(upward), colours);

    pane.scaleBar(width - 0.8 * rem, height - 0.9 * rem, along, colours);
    pane.scaleBar(width - 1 * rem, height - 3 * rem, scale, colours, true);
    pane.font(0.85);
    const ratio = scale / along;
    pane.text(`${Math.abs(ratio - 1) < 0.05 ? 'true scale' : `across ${ratio < 10 ? ratio.toFixed(1) : Math.round(ratio)} : 1 along`}; ${across.text()}` +
        (g.free_length_um > 0 && bend !== 1 ? `; bending \u00d7${bend}` : ''), 0.7 * rem, height - 0.8 * rem, colours.ink, colours.ferruleCut);
    axes(pane, 1.2 * rem, height - 2.6 * rem, colours, 'x', this.up, '');
    const arrow = round(read('limit_uN'));
    pane.text(`arrow as long as this: ${arrow} \u00b5N`, width - 0.8 * rem - arrow * force - 0.6 * rem, 1.3 * rem, colours.ink, colours.ferruleCut, 'right');
    pane.arrow(width - 0.8 * rem - arrow * force, rem, arrow * force, 0, colours.ink, 0.12);
  }
}

/** A round share of the limit. @param {number} limit */
function round(limit) {
  return Number((limit / 4).toPrecision(1));
}

/** @param {CanvasRenderingContext2D} c @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 @param {string} colour @param {number[]} dash */
function line(c, x0, y0, x1, y1, colour, dash) {
  c.setLineDash(dash);
  c.strokeStyle = colour;
  c.lineWidth = dash.length ? 1.2 : 1.5;
  c.beginPath();
  c.moveTo(x0, y0);
  c.lineTo(x1, y1);
  c.stroke();
  c.setLineDash([]);
}
