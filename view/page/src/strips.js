// Velocity and force over time, in the manner of the paper's Fig. 10 (uPlot).
import uPlot from 'uplot';
import {withFasterCanvas} from './software.js';

/** @typedef {import('./table.js').Table} Table @typedef {import('./theme.js').Colours} Colours */

const kMostPoints = 1500;
const kDashes = [[], [8, 4], [2, 4]];

export class Strips {
  /** @param {HTMLElement} velocity @param {HTMLElement} force @param {(t: number) => void} pick  a time was clicked */
  constructor(velocity, force, pick) {
    this.places = [velocity, force];
    this.pick = pick;
    /** @type {uPlot[]} */
    this.plots = [];
    this.cursor = NaN;
    /** @type {{table: Table, rows: number, other: Table | null, colours: Colours} | null} */
    this.shown = null;
  }

  /** New axes, for new colours or another size of text. @param {Colours} colours */
  build(colours) {
    for (const plot of this.plots) plot.destroy();
    this.shown = null;
    const rem = parseFloat(getComputedStyle(document.documentElement).fontSize);
    const font = `${0.78 * rem}px system-ui, sans-serif`;
    const titles = ['velocity [\u00b5m/s]', 'force [\u00b5N]'];
    this.plots = this.places.map((place, which) => {
      const names = which === 0 ? ['v_x', 'v_y', 'v_z'] : ['F_x', 'F_y', 'F_z'];
      const axis = {
        font, labelFont: font, stroke: colours.ink, grid: {stroke: colours.line, width: 1},
        ticks: {stroke: colours.line, width: 1, size: 0.3 * rem}, gap: 0.25 * rem,
      };
      const line = (/** @type {string} */ label, /** @type {string} */ stroke, /** @type {number[]} */ dash, width = 0.11) =>
          ({label, stroke, dash, width: width * rem, points: {show: false}});
      const series = [colours.x, colours.y, colours.z].map((colour, i) => line(names[i], colour, kDashes[i]));
      if (which === 1) series.push(line('limit', colours.ink, [10, 4, 2, 4], 0.09));
      series.push(line('other', colours.ghost, [3, 3], 0.14));
      const plot = withFasterCanvas(() => new uPlot({
        width: place.clientWidth || 300, height: place.clientHeight || 120,
        series: [{label: 't'}, ...series],
        axes: [
          {...axis, size: 1.7 * rem, space: 4 * rem, values: (_, splits) => splits.map((t) => `${Number(t.toFixed(3))} s`)},
          {...axis, values: (_, splits) => splits.map((x) => String(Number(x.toPrecision(6))).replace('-', '\u2212')), size: 3.2 * rem, label: titles[which], labelSize: 1.3 * rem, labelGap: 0, space: 1.8 * rem},
        ],
        scales: {x: {time: false}, y: {range: (_, low, high) => padded(low, high)}},
        legend: {show: false},
        cursor: {show: false},
        padding: [0.5 * rem, 1.5 * rem, 0, 0],
        hooks: {draw: [(plot) => this.mark(plot, colours)]},
      }, [[], ...series.map(() => [])], place));
      plot.over.addEventListener('click', (event) => this.pick(plot.posToVal(event.offsetX, 'x')));
      return plot;
    });
  }

  resize() {
    this.plots.forEach((plot, i) => {
      const {clientWidth: width, clientHeight: height} = this.places[i];
      if (width > 8 && height > 8 && (plot.width !== width || plot.height !== height)) plot.setSize({width, height});
    });
  }

  /**
   * @param {Table} table @param {Table | null} other @param {number} begin first row @param {[number, number]} span of time shown [s]
   */
  show(table, other, begin, span) {
    const stride = Math.max(1, Math.floor((table.rows - begin) / kMostPoints));
    // Over another run, the longer one decides how far time goes.
    const t = other ? Float64Array.from({length: kMostPoints}, (_, i) => span[0] + (span[1] - span[0]) * i / (kMostPoints - 1))
                    : table.column('t_s', begin, stride);
    const columns = [
      ['velocity_x_um_s', 'velocity_y_um_s', 'velocity_z_um_s'],
      ['force_x_uN', 'force_y_uN', 'force_z_uN', 'limit'],
    ];
    this.plots.forEach((plot, which) => {
      const data = columns[which].map((name) => name === 'limit' ? this.limits(table, begin, t) : other ? sampled(table, name, t) : table.column(name, begin, stride));
      const name = which === 0 ? 'velocity_x_um_s' : 'force_x_uN';
      data.push(other ? sampled(other, name, t) : new Float64Array(t.length).fill(NaN));
      // NaN draws nothing in uPlot as null does.
      plot.setData(/** @type {uPlot.AlignedData} */ ([t, ...data.map((d) => Array.from(d, (x) => Number.isNaN(x) ? null : x))]), false);
      plot.setScale('x', {min: span[0], max: span[1]});
    });
  }

  /** The limit, where the force comes near it. @param {Table} table @param {number} begin @param {Float64Array} t */
  limits(table, begin, t) {
    const limit = table.at(begin, 'limit_uN');
    let largest = 0;
    for (const x of table.column('force_uN', begin, 1)) largest = Math.max(largest, x);
    return new Float64Array(t.length).fill(largest > 0.5 * limit ? limit : NaN);
  }

  /** Where the picture is in time. @param {number} t [s] */
  point(t) {
    if (t === this.cursor) return;
    this.cursor = t;
    for (const plot of this.plots) plot.redraw(false, false);
  }

  /** @param {uPlot} plot @param {Colours} colours */
  mark(plot, colours) {
    if (Number.isNaN(this.cursor)) return;
    const x = plot.valToPos(this.cursor, 'x', true);
    const {left, top, width, height} = plot.bbox;
    if (x < left || x > left + width) return;
    plot.ctx.save();
    plot.ctx.strokeStyle = colours.ink;
    plot.ctx.lineWidth = 1.5 * devicePixelRatio;
    plot.ctx.beginPath();
    plot.ctx.moveTo(x, top);
    plot.ctx.lineTo(x, top + height);
    plot.ctx.stroke();
    plot.ctx.restore();
  }
}

/** @param {number | null} low @param {number | null} high @returns {[number, number]} */
function padded(low, high) {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [-1, 1];
  const room = Math.max(0.08 * (high - low), 0.02 * Math.max(Math.abs(low), Math.abs(high)), 0.05);
  return [Math.min(low - room, 0), Math.max(high + room, 0)];
}

/** A column of another table at the times `t`. @param {Table} table @param {string} name @param {Float64Array} t */
function sampled(table, name, t) {
  const [first, last] = table.span();
  return t.map((time) => time < first || time > last ? NaN : table.at(table.rowAt(time), name));
}
