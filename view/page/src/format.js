// Numbers as text that keeps its width, so that it does not jitter.

const kMinus = '\u2212';  // as wide as a figure

/** @param {number} x @param {number} digits after the point */
export function fixed(x, digits) {
  if (!Number.isFinite(x)) return '\u2013';
  let text = Math.abs(x).toFixed(digits);
  if (x < 0 && Number(text) !== 0) text = kMinus + text;
  return text;
}

/** Three figures, for what spans decades. @param {number} x */
export function significant(x) {
  if (!Number.isFinite(x)) return '\u2013';
  const size = Math.abs(x);
  const digits = size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.9995 ? 2 : 3;
  return fixed(x, digits);
}

/** A term or outcome as words. @param {string} name */
export function words(name) {
  return name === 'van_der_waals' ? 'van der Waals' : name.replaceAll('_', ' ');
}

/** The largest of 1, 2, 5, 10 ... not above `x` > 0. @param {number} x */
export function round125(x) {
  const power = 10 ** Math.floor(Math.log10(x) + 1e-9);
  const rest = x / power;
  return power * (rest >= 5 - 1e-9 ? 5 : rest >= 2 - 1e-9 ? 2 : 1);
}

/** A length with a unit that suits it. @param {number} um */
export function length(um) {
  if (um >= 1000) return `${Number((um / 1000).toPrecision(3))} mm`;
  if (um >= 0.1) return `${Number(um.toPrecision(3))} \u00b5m`;
  return `${Number((um * 1000).toPrecision(3))} nm`;
}

/** @template {keyof HTMLElementTagNameMap} K @param {K} tag @param {string} [text] @param {string} [className] */
export function element(tag, text, className) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

/** @template {HTMLElement} T @param {string} id @param {new () => T} type @returns {T} */
export function byId(id, type) {
  const found = document.getElementById(id);
  if (!(found instanceof type)) throw new Error(`no #${id} in the page`);
  return found;
}
