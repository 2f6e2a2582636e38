// A canvas that is as sharp as the screen, and what is drawn in several of them.
import {length, round125} from './format.js';
import {kPlane} from './software.js';

/** @typedef {import('./theme.js').Colours} Colours */

export class Pane {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    const context = canvas.getContext('2d', {willReadFrequently: kPlane.willReadFrequently});
    if (!context) throw new Error('no 2-D canvas in this browser');
    this.context = context;
    this.width = this.height = 1;
    this.rem = 16;
  }

  /** Clears it for the next picture, in CSS pixels. False while it is not shown. */
  begin() {
    const ratio = devicePixelRatio || 1;
    const width = this.canvas.clientWidth, height = this.canvas.clientHeight;
    if (width < 8 || height < 8) return false;
    const w = Math.round(width * ratio), h = Math.round(height * ratio);
    if (this.canvas.width !== w || this.canvas.height !== h) {
      this.canvas.width = w;
      this.canvas.height = h;
    }
    this.width = width;
    this.height = height;
    this.rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.clearRect(0, 0, width, height);
    this.context.lineCap = 'round';
    this.context.lineJoin = 'round';
    return true;
  }

  /** @param {number} rems */
  font(rems) {
    this.context.font = `${rems * this.rem}px system-ui, sans-serif`;
  }

  /** A text with a halo of the ground. @param {string} text @param {number} x @param {number} y @param {string} colour @param {string} halo @param {CanvasTextAlign} [align] */
  text(text, x, y, colour, halo, align = 'left') {
    const c = this.context;
    c.textAlign = align;
    c.lineWidth = 0.25 * this.rem;
    c.strokeStyle = halo;
    c.strokeText(text, x, y);
    c.fillStyle = colour;
    c.fillText(text, x, y);
  }

  /** @param {number} x @param {number} y @param {number} dx @param {number} dy @param {string} colour @param {number} [width] */
  arrow(x, y, dx, dy, colour, width = 0.18) {
    const size = Math.hypot(dx, dy);
    if (size < 1) return;
    const c = this.context, head = Math.min(0.55 * this.rem, 0.6 * size);
    const ux = dx / size, uy = dy / size, bx = x + dx - ux * head, by = y + dy - uy * head;
    c.strokeStyle = c.fillStyle = colour;
    c.lineWidth = width * this.rem;
    c.setLineDash([]);
    c.beginPath();
    c.moveTo(x, y);
    c.lineTo(bx, by);
    c.stroke();
    c.beginPath();
    c.moveTo(x + dx, y + dy);
    c.lineTo(bx - uy * head * 0.5, by + ux * head * 0.5);
    c.lineTo(bx + uy * head * 0.5, by - ux * head * 0.5);
    c.fill();
  }

  /** Which way to correct, and by how much [um]. @param {number} x @param {number} y @param {number} dx @param {number} dy @param {number} um @param {Colours} colours */
  cue(x, y, dx, dy, um, colours) {
    const size = Math.hypot(dx, dy), most = Math.max(size, 3 * this.rem);
    if (!(size > 0)) return;
    const ux = dx / size, uy = dy / size;
    this.arrow(x, y, ux * most, uy * most, colours.good, 0.4);
    this.font(1.1);
    const edge = 2.5 * this.rem, at = Math.max(edge, Math.min(this.width - edge, x + ux * (most + 1.8 * this.rem)));
    this.text(length(um), at, y + uy * (most + 1.2 * this.rem) + 0.4 * this.rem, colours.good, colours.ferruleCut, 'center');
  }

  /** A scale bar whose right end is at x. @param {number} x @param {number} y @param {number} pixelsPerUm @param {Colours} colours @param {boolean} [upright] */
  scaleBar(x, y, pixelsPerUm, colours, upright = false) {
    const um = round125(5.5 * this.rem / pixelsPerUm), size = um * pixelsPerUm;
    const c = this.context, tick = 0.25 * this.rem;
    c.strokeStyle = colours.ink;
    c.lineWidth = 0.12 * this.rem;
    c.setLineDash([]);
    c.beginPath();
    if (upright) {
      c.moveTo(x - tick, y - size); c.lineTo(x + tick, y - size);
      c.moveTo(x, y - size); c.lineTo(x, y);
      c.moveTo(x - tick, y); c.lineTo(x + tick, y);
    } else {
      c.moveTo(x - size, y - tick); c.lineTo(x - size, y + tick);
      c.moveTo(x - size, y); c.lineTo(x, y);
      c.moveTo(x, y - tick); c.lineTo(x, y + tick);
    }
    c.stroke();
    this.font(0.85);
    if (upright) this.text(length(um), x - 0.5 * this.rem, y - size / 2 + 0.3 * this.rem, colours.ink, colours.ferruleCut, 'right');
    else this.text(length(um), x - size / 2, y - 0.45 * this.rem, colours.ink, colours.ferruleCut, 'center');
  }

  /** @param {number} x @param {number} y @param {string} colour @param {string} halo */
  contact(x, y, colour, halo) {
    const c = this.context;
    c.beginPath();
    c.arc(x, y, 0.42 * this.rem, 0, 2 * Math.PI);
    c.fillStyle = colour;
    c.fill();
    c.lineWidth = 0.12 * this.rem;
    c.setLineDash([]);
    c.strokeStyle = halo;
    c.stroke();
  }
}

/** Force arrows: pixels per uN, so that the limit is a third of the pane. @param {number} limit [uN] @param {number} pixels */
export function forceScale(limit, pixels) {
  return limit > 0 ? pixels / limit : 0;
}
