// Along the axis, as the holder sees it: where in the play the fibre's end is, and where the fibre
// crosses the bore's mouth. y is up; z to the left.
import {forceScale, Pane} from './pane.js';
import {atMouth, contacts, filledWithLiquid, hidden, termForces, wayToAxis} from './shape.js';

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene
 * @typedef {import('./theme.js').Colours} Colours @typedef {import('./magnify.js').Magnification} Magnification */

export class AxisView {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.pane = new Pane(canvas);
  }

  /** @param {Scene} scene @param {Read} read @param {Read | null} other @param {Magnification} across @param {Colours} colours */
  draw(scene, read, other, across, colours) {
    const pane = this.pane;
    if (!pane.begin()) return;
    const {context: c, width, height, rem} = pane;
    const half = Math.min(width, height) / 2;
    across.fit(scene, other ? [read, other] : [read], half);
    const {scale, radius, factor} = across;
    const g = scene.geometry;
    const cx = width / 2, cy = height / 2;
    const gap = (g.bore_radius_um - g.fibre_radius_um) * scale, bore = radius + gap;
    const mouth = radius + (g.mouth_radius_um - g.fibre_radius_um) * scale;
    const screen = (/** @type {number} */ y, /** @type {number} */ z) =>
        /** @type {[number, number]} */ ([cx - z * scale, cy - y * scale]);
    const circle = (/** @type {number} */ x, /** @type {number} */ y, /** @type {number} */ r) => {
      c.beginPath();
      c.arc(x, y, r, 0, 2 * Math.PI);
    };

    // The solid: face, cone, bore.
    c.fillStyle = colours.ferruleCut;
    c.fillRect(0, 0, width, height);
    if (g.lead_in_length_um > 0) {
      circle(cx, cy, Math.min(mouth, 4 * (width + height)));
      const shade = c.createRadialGradient(cx, cy, bore, cx, cy, Math.max(bore + 1, Math.min(mouth, width + height)));
      shade.addColorStop(0, colours.ferrule);
      shade.addColorStop(1, colours.ferruleCut);
      c.fillStyle = shade;
      c.fill();
      c.strokeStyle = colours.line;
      c.lineWidth = 0.08 * rem;
      c.stroke();
    }
    circle(cx, cy, bore);
    c.fillStyle = filledWithLiquid(scene) ? colours.liquid : colours.ground;
    c.fill();
    c.strokeStyle = colours.ink;
    c.lineWidth = 0.15 * rem;
    c.stroke();
    // Play: the centre of the end stays in this circle while it is in the bore.
    c.strokeStyle = colours.soft;
    c.lineWidth = 0.08 * rem;
    if (gap > rem) {
      circle(cx, cy, gap);
      c.setLineDash([0.3 * rem, 0.3 * rem]);
      c.stroke();
      c.setLineDash([]);
    }
    cross(c, cx, cy, 0.5 * rem, colours.soft);

    if (other) {
      const [x, y] = screen(other('tip_y_um'), other('tip_z_um'));
      circle(x, y, radius);
      c.strokeStyle = colours.ghost;
      c.lineWidth = 0.2 * rem;
      c.setLineDash([0.7 * rem, 0.5 * rem]);
      c.stroke();
      c.setLineDash([]);
    }
    // Where the holder is: the dashed circle is the end of a fibre that nothing bends.
    const [hx, hy] = screen(read('holder_y_um'), read('holder_z_um'));
    const crossing = atMouth(read);
    const [mx, my] = screen(crossing.y, crossing.z);
    const [tx, ty] = screen(read('tip_y_um'), read('tip_z_um'));
    circle(tx, ty, radius);
    c.globalAlpha = 0.85;
    c.fillStyle = colours.fibre;
    c.fill();
    c.globalAlpha = 1;
    c.strokeStyle = colours.fibreEdge;
    c.lineWidth = 0.18 * rem;
    c.stroke();
    if (Math.hypot(mx - tx, my - ty) > 1) {
      circle(mx, my, radius);
      c.setLineDash([0.2 * rem, 0.35 * rem]);
      c.stroke();
      c.setLineDash([]);
    }
    if (Math.hypot(hx - tx, hy - ty) > 1.5) {
      circle(hx, hy, radius);
      c.strokeStyle = colours.hand;
      c.lineWidth = 0.12 * rem;
      c.setLineDash([0.5 * rem, 0.4 * rem]);
      c.stroke();
      c.setLineDash([]);
    }
    cross(c, tx, ty, 0.7 * rem, colours.fibreEdge);
    if (read('bridge_on') > 0.5) bridge(c, tx, ty, cx, cy, radius, bore, colours.liquid);

    for (const {place, at} of contacts(read)) {
      // The place on the wall, in the direction that it has from the fibre's axis: of the end, or
      // where that crosses the mouth.
      const [x, y] = place === 0 ? [tx, ty] : [mx, my];
      const centre = place === 0 ? {y: read('tip_y_um'), z: read('tip_z_um')} : crossing;
      const dy = at[1] - centre.y, dz = at[2] - centre.z, r = Math.hypot(dy, dz);
      if (r > 0) pane.contact(x - radius * dz / r, y - radius * dy / r, colours.contact, colours.ground);
    }
    const force = forceScale(read('limit_uN'), 0.9 * half);
    for (const {term, force: [, y, z]} of termForces(scene, read))
      pane.arrow(tx, ty, -z * force, -y * force, colours.terms[term] ?? colours.ink);
    if (!hidden.has('hand')) pane.arrow(tx, ty, -read('force_z_uN') * force, -read('force_y_uN') * force, colours.hand, 0.3);

    const way = wayToAxis(scene, read);
    if (way) pane.cue(tx, ty, way.right * scale, -way.up * scale, way.size, colours);

    pane.scaleBar(width - 0.8 * rem, height - 0.9 * rem, scale, colours);
    pane.font(0.85);
    pane.text(factor < 1.05 ? 'true scale' : `clearance \u00d7${factor < 10 ? factor.toFixed(1) : Math.round(factor)}`,
        0.7 * rem, height - 0.8 * rem, colours.ink, colours.ferruleCut);
    axes(pane, 2.6 * rem, height - 2.6 * rem, colours, '', 'y', 'z');
  }
}

/** @param {CanvasRenderingContext2D} c @param {number} x @param {number} y @param {number} r @param {string} colour */
function cross(c, x, y, r, colour) {
  c.strokeStyle = colour;
  c.beginPath();
  c.moveTo(x - r, y); c.lineTo(x + r, y);
  c.moveTo(x, y - r); c.lineTo(x, y + r);
  c.stroke();
}

/** The liquid between fibre and wall where the gap is smallest. @param {CanvasRenderingContext2D} c @param {number} x @param {number} y @param {number} cx @param {number} cy @param {number} radius @param {number} bore @param {string} colour */
function bridge(c, x, y, cx, cy, radius, bore, colour) {
  const angle = Math.atan2(y - cy, x - cx), wide = 0.5;
  c.beginPath();
  c.arc(x, y, radius, angle - wide, angle + wide);
  c.arc(cx, cy, bore, angle + wide, angle - wide, true);
  c.closePath();
  c.fillStyle = colour;
  c.fill();
}

/** Small axes: `right` or `left` name what points there. @param {Pane} pane @param {number} x @param {number} y @param {Colours} colours @param {string} right @param {string} up @param {string} left */
export function axes(pane, x, y, colours, right, up, left) {
  const size = 1.7 * pane.rem, r = 0.35 * pane.rem;
  pane.font(0.85);
  pane.arrow(x, y, 0, -size, colours.soft, 0.1);
  pane.text(up, x - r, y - size - r, colours.soft, colours.ferruleCut);
  const way = right ? 1 : -1;
  pane.arrow(x, y, way * size, 0, colours.soft, 0.1);
  pane.text(right || left, x + way * (size + 0.5 * pane.rem), y + r, colours.soft, colours.ferruleCut, 'center');
}
