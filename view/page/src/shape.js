// Where fibre and bore are in one frame, for the views.

/** @typedef {import('./table.js').Read} Read @typedef {import('./recording.js').Scene} Scene */

/** Forces whose arrows the person does not want: terms, `hand`. @type {Set<string>} */
export const hidden = new Set();

/** How much of a fibre without an elastic part is drawn [um]. */
const kRigidLength = 2000;

/**
 * Centre of the fibre, `s` [um] from its end towards the holder; a rigid fibre is straight, an
 * elastic one a cubic between its end and its clamp. `bend` exaggerates how far it is from straight.
 * @param {Scene} scene @param {Read} read @param {number} s @param {number} bend
 * @returns {[number, number, number]} x, y, z [um]
 */
export function fibreAt(scene, read, s, bend) {
  const x = read('tip_x_um') + s;
  return [x, across(scene, read, s, bend, 'y'), across(scene, read, s, bend, 'z')];
}

/** @param {Scene} scene @param {Read} read @param {number} s @param {number} bend @param {'y' | 'z'} axis */
function across(scene, read, s, bend, axis) {
  const tip = read(`tip_${axis}_um`), tilt = read(`tip_a${axis}_rad`);
  const straight = tip + s * tilt;
  const length = scene.geometry.free_length_um;
  if (!(length > 0) || bend === 0) return straight;
  // Clamped at `length`, where the holder's own line is; displaced and turned at the end.
  const clampTilt = read(`holder_a${axis}_rad`);
  const offset = tip - read(`holder_${axis}_um`), turn = tilt - clampTilt;
  const u = s / length;
  const shape = offset * (1 - 3 * u * u + 2 * u ** 3) + turn * length * (u - 2 * u * u + u ** 3);
  const line = read(`holder_${axis}_um`) + s * clampTilt;
  return straight + bend * (line + shape - straight);
}

/** How far the fibre is drawn from its end [um]. @param {Scene} scene */
export function drawnLength(scene) {
  return scene.geometry.free_length_um || kRigidLength;
}

/** Where the fibre's axis crosses the plane of the bore's mouth, or its end before it [um]. @param {Read} read */
export function atMouth(read) {
  const depth = Math.max(0, -read('tip_x_um'));
  return {y: read('tip_y_um') + depth * read('tip_ay_rad'), z: read('tip_z_um') + depth * read('tip_az_rad')};
}

/**
 * What is to be seen of the forces: each term that acts, and where it is drawn from.
 * @param {Scene} scene @param {Read} read
 * @returns {{term: string, force: [number, number, number], at: [number, number, number]}[]} [uN], [um]
 */
export function termForces(scene, read) {
  const tip = /** @type {[number, number, number]} */ (
      [read('tip_x_um'), read('tip_y_um'), read('tip_z_um')]);
  const contact = contacts(read)[0];
  return scene.terms.filter((term) => !hidden.has(term)).map((term) => ({
    term,
    force: /** @type {[number, number, number]} */ (
        ['x', 'y', 'z'].map((axis) => read(`${term}_${axis}_uN`))),
    at: contact && ['adhesion', 'wall', 'friction'].includes(term) ? contact.at : tip,
  }));
}

/** @param {Read} read @returns {{place: number, at: [number, number, number], N: number}[]} */
export function contacts(read) {
  const found = [];
  for (const place of [0, 1])
    if (read(`contact${place}_on`) > 0.5)
      found.push({
        place,
        at: /** @type {[number, number, number]} */ (
            ['x', 'y', 'z'].map((axis) => read(`contact${place}_${axis}_um`))),
        N: read(`contact${place}_N_uN`),
      });
  return found;
}

/**
 * Which way the hand has to correct sideways, as seen along the axis (right is -z) [um]; null where
 * that is less than a quarter of the play, or not shown in this scene.
 * @param {Scene} scene @param {Read} read @returns {{right: number, up: number, size: number} | null}
 */
export function wayToAxis(scene, read) {
  const right = -read('way_z_um'), up = read('way_y_um'), size = Math.hypot(right, up);
  const play = scene.geometry.bore_radius_um - scene.geometry.fibre_radius_um;
  return scene.cue === true && size > 0.25 * play ? {right, up, size} : null;
}

/** @param {Scene} scene */
export function filledWithLiquid(scene) {
  return scene.terms.includes('drag') || scene.terms.includes('meniscus');
}
