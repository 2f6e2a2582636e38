// What is to be replayed: runs of rows with events, and the map of the trials they are of.
import {withMicro} from './format.js';
import {Table} from './table.js';

/**
 * @typedef {{fibre_radius_um: number, bore_radius_um: number, bore_length_um: number,
 *   lead_in_length_um: number, mouth_radius_um: number, free_length_um: number,
 *   liquid?: {film_um: number, rupture_um: number}}} Geometry
 * @typedef {{name: string, about: string, geometry: Geometry, terms: string[],
 *   limits: {force_uN: number, speed_um_s: number, time_s: number},
 *   start: {distance_um: number}, success_depth_um: number, cue?: boolean}} Scene
 * @typedef {{t_s: number, row: number, kind: string, text: string}} Event
 * @typedef {{name: string, outcome: string, why: string, rows?: string, count: number,
 *   events: Event[], file?: string, trial?: number, scene?: Scene}} RunJson
 * @typedef {{trial: number, y_um: number, z_um: number, outcome: string, run?: number}} MapPoint
 * @typedef {{title: string, command: string, points: MapPoint[]}} MapJson
 * @typedef {{mode: 'replay', title?: string, scene: Scene, columns: string[], phases: string[],
 *   runs: RunJson[], maps?: MapJson[], over?: number}} RecordedJson
 * @typedef {{mode: 'playground'}} Within the simulator is in the page (playground.js)
 * @typedef {{mode: 'live', hello: import('./live.js').Message, state: import('./live.js').Message, frame: (number | null)[]}} FirstPicture
 */

/** One insertion that is over. */
export class RecordedRun {
  /** @param {RunJson} json @param {string[]} columns @param {Scene} scene */
  constructor(json, columns, scene) {
    this.name = String(json.name);
    this.outcome = String(json.outcome ?? '');
    this.why = withMicro(String(json.why ?? ''));
    this.scene = json.scene ?? scene;
    this.file = json.file;
    this.trial = json.trial;
    this.events = Array.isArray(json.events) ? json.events.map((event) => ({...event, text: withMicro(String(event.text ?? ''))})) : [];
    this.table = new Table(columns);
    /** @type {string | undefined} rows that are still packed */
    this.packed = json.rows;
  }
  get loaded() {
    return this.table.rows > 0;
  }

  async unpack() {
    if (this.packed === undefined) return;
    const data = await unpacked(this.packed, this.table.columns.length);
    if (!this.loaded) this.table.append(data);
    this.packed = undefined;
  }
}

/** What view/packed_rows.hpp packs. @param {string} base64 @param {number} columns @returns {Promise<Float32Array>} */
export async function unpacked(base64, columns) {
  const text = atob(base64), packed = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) packed[i] = text.charCodeAt(i);
  const inflated = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate-raw'));
  const planes = new Uint8Array(await new Response(inflated).arrayBuffer());
  const rows = Math.floor(planes.length / (4 * columns));
  const bits = new Uint32Array(rows * columns);
  for (let column = 0; column < columns; ++column) {
    const begin = 4 * column * rows;
    for (let row = 0, sum = 0; row < rows; ++row) {
      const at = begin + row;
      sum = sum + planes[at] + (planes[at + rows] << 8) + (planes[at + 2 * rows] << 16) + (planes[at + 3 * rows] << 24) | 0;
      bits[row * columns + column] = sum;
    }
  }
  return new Float32Array(bits.buffer);
}

/**
 * What an exported file holds; 'served' where the program has it; null where there is nothing; of a running program what is drawn first.
 * @returns {RecordedJson | FirstPicture | Within | 'served' | null}
 */
export function embedded() {
  const text = document.getElementById('recorded')?.textContent?.trim();
  return text ? JSON.parse(text) : null;
}
