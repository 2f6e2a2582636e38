// Light and dark: as the system says, until the user chooses. Colours are the variables of style.css.

/** @typedef {{ink: string, soft: string, line: string, panel: string, ground: string, fibre: string,
 *   fibreEdge: string, ferrule: string, ferruleCut: string, liquid: string, hand: string, ghost: string,
 *   alarm: string, contact: string, good: string, x: string, y: string, z: string,
 *   terms: Record<string, string>}} Colours */

const kTerms = ['van_der_waals', 'electrostatic', 'gravity', 'capillary', 'adhesion', 'wall',
  'friction', 'drag', 'meniscus', 'flow', 'particle'];

/** @returns {Colours} */
export function colours() {
  const style = getComputedStyle(document.documentElement);
  const get = (/** @type {string} */ name) => style.getPropertyValue('--' + name).trim();
  return {
    ink: get('ink'), soft: get('soft'), line: get('line'), panel: get('panel'),
    ground: get('ground'), fibre: get('fibre'), fibreEdge: get('fibre-edge'),
    ferrule: get('ferrule'), ferruleCut: get('ferrule-cut'), liquid: get('liquid'),
    hand: get('hand'), ghost: get('ghost'), alarm: get('alarm'), contact: get('contact'),
    good: get('good'), x: get('x'), y: get('y'), z: get('z'),
    terms: Object.fromEntries(kTerms.map((term) => [term, get(term.replaceAll('_', '-'))])),
  };
}

const dark = matchMedia('(prefers-color-scheme: dark)');

export function isDark() {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === 'dark' : dark.matches;
}

/** @param {() => void} changed */
export function watchTheme(changed) {
  dark.addEventListener('change', changed);
  const remembered = stored('ferrule-theme');
  if (remembered) document.documentElement.dataset.theme = remembered;
  const apply = () => {
    document.documentElement.dataset.theme = isDark() ? 'light' : 'dark';
    store('ferrule-theme', document.documentElement.dataset.theme);
    changed();
  };
  return apply;
}

/** @param {string} key */
function stored(key) {
  try {
    const value = localStorage.getItem(key);
    return value === 'dark' || value === 'light' ? value : null;
  } catch {  // a file from disk may have no storage
    return null;
  }
}

/** @param {string} key @param {string} value */
function store(key, value) {
  try {
    localStorage.setItem(key, value);
  } catch {
    // then it is not remembered
  }
}
