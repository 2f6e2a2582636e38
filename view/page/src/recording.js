// What is to be replayed: runs of rows with events, and the map of the trials they are of.
import {Table} from './table.js';

/**
 * @typedef {{fibre_radius_um: number, bore_radius_um: number, bore_length_um: number,
 *   lead_in_length_um: number, mouth_radius_um: number, free_length_um: number,
 *   liquid?: {film_um: number, rupture_um: number}}} Geometry
 * @typedef {{name: string, about: string, geometry: Geometry, terms: string[],
 *   limits: {force_uN: number, speed_um_s: number, time_s: number},
 *   start: {distance_um: number}, success_depth_um: number}} Scene
 * @typedef {{t_s: number, row: number, kind: string, text: string}} Event
 * @typedef {{name: string, outcome: string, why: string, rows?: string, count: number,
 *   events: Event[], file?: string, trial?: number, scene?: Scene}} RunJson
 * @typedef {{trial: number, y_um: number, z_um: number, outcome: string, run?: number}} MapPoint
 * @typedef {{title: string, command: string, points: MapPoint[]}} MapJson
 * @typedef {{mode: 'replay', title?: string, scene: Scene, columns: string[], phases: string[],
 *   runs: RunJson[], maps?: MapJson[], over?: number}} RecordedJson
 */

/** One insertion that is over. */
export class RecordedRun {
  /** @param {RunJson} json @param {string[]} columns @param {Scene} scene */
  constructor(json, columns, scene) {
    this.name = String(json.name);
    this.outcome = String(json.outcome ?? '');
    this.why = String(json.why ?? '');
    this.scene = json.scene ?? scene;
    this.file = json.file;
    this.trial = json.trial;
    this.events = Array.isArray(json.events) ? json.events : [];
    this.table = new Table(columns);
    if (json.rows !== undefined) this.table.append(floats(json.rows));
  }
  get loaded() {
    return this.table.rows > 0;
  }
}

/** @param {string} base64 of little-endian float32 @returns {Float32Array} */
export function floats(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return new Float32Array(bytes.buffer, 0, bytes.length >> 2);
}

/** What an exported file holds; 'served' where the program has it; null where there is nothing. @returns {RecordedJson | 'served' | null} */
export function embedded() {
  const text = document.getElementById('recorded')?.textContent?.trim();
  return text ? JSON.parse(text) : null;
}
