// Frames of an insertion: a table of float32, columns by name (view/frame.cpp says which).

/** @typedef {(name: string) => number} Read  one row, read by the name of a column; NaN: no such column */

export class Table {
  /**
   * @param {string[]} columns
   * @param {number} [keep] rows to keep at most; older ones are dropped
   */
  constructor(columns, keep = Infinity) {
    this.columns = columns;
    this.index = new Map(columns.map((name, i) => [name, i]));
    this.keep = keep;
    this.rows = 0;
    this.data = new Float32Array(columns.length * 1024);
  }

  /** @param {Float32Array} data row major */
  append(data) {
    const width = this.columns.length;
    const more = Math.floor(data.length / width);
    if (this.rows + more > 2 * this.keep) {  // half of it is old
      const drop = Math.max(0, this.rows - this.keep);
      this.data.copyWithin(0, drop * width, this.rows * width);
      this.rows -= drop;
    }
    const needed = (this.rows + more) * width;
    if (needed > this.data.length) {
      const larger = new Float32Array(Math.max(needed, 2 * this.data.length));
      larger.set(this.data.subarray(0, this.rows * width));
      this.data = larger;
    }
    this.data.set(data.subarray(0, more * width), this.rows * width);
    this.rows += more;
  }

  clear() {
    this.rows = 0;
  }

  /** @param {number} row @param {string} name */
  at(row, name) {
    const column = this.index.get(name);
    if (column === undefined || row < 0 || row >= this.rows) return NaN;
    return this.data[row * this.columns.length + column];
  }

  /** @param {number} row @returns {Read} */
  read(row) {
    return (name) => this.at(row, name);
  }

  /** The last row whose time is not after `t`; the first where there is none. @param {number} t [s] */
  rowAt(t) {
    let low = 0, high = this.rows - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.at(middle, 't_s') <= t + 1e-6) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  /** Time of the first row and of the last [s]. */
  span() {
    return this.rows ? [this.at(0, 't_s'), this.at(this.rows - 1, 't_s')] : [0, 0];
  }

  /**
   * A column from row `begin` on, every `stride`-th row.
   * @param {string} name @param {number} begin @param {number} stride
   */
  column(name, begin, stride) {
    const column = this.index.get(name) ?? -1;
    const width = this.columns.length;
    const out = new Float64Array(Math.max(0, Math.ceil((this.rows - begin) / stride)));
    for (let i = 0, row = begin; i < out.length; ++i, row += stride)
      out[i] = column < 0 ? NaN : this.data[row * width + column];
    return out;
  }
}
