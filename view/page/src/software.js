// Whether the browser renders without a graphics processor: then its 2-D canvases are faster by the
// processor alone than by an emulated GPU, and 3-D is drawn less often than the rest.

/** @returns {boolean} */
function detect() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return true;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|basic render|software/i.test(name);
}

export const software = detect();

/** Makes what asks for 2-D contexts itself (uPlot) take the faster ones. @template T @param {() => T} make @returns {T} */
export function withFasterCanvas(make) {
  if (!software) return make();
  const prototype = HTMLCanvasElement.prototype, original = prototype.getContext;
  /** @this {HTMLCanvasElement} @param {string} kind @param {object} [options] */
  function faster(kind, options) {
    return original.call(this, kind, kind === '2d' ? {...options, willReadFrequently: true} : options);
  }
  prototype.getContext = /** @type {typeof original} */ (faster);
  try {
    return make();
  } finally {
    prototype.getContext = original;
  }
}
