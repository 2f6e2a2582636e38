// Whether the browser renders without a graphics processor: then 3-D is drawn less often than the rest,
// coarser and without smoothed edges.

/** Known once it was looked for: that takes the start of the browser's renderer, after the first picture. */
export let software = true;

export function detectSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  if (!gl) return;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const name = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  software = /swiftshader|llvmpipe|softpipe|basic render|software/i.test(name);
}

/** Of 2-D canvases: lines and texts, drawn by the processor at once, wherever the rest is rendered. */
export const kPlane = {willReadFrequently: true};

/** Makes what asks for 2-D contexts itself (uPlot) take such ones. @template T @param {() => T} make @returns {T} */
export function withPlaneCanvas(make) {
  const prototype = HTMLCanvasElement.prototype, original = prototype.getContext;
  /** @this {HTMLCanvasElement} @param {string} kind @param {object} [options] */
  function plane(kind, options) {
    return original.call(this, kind, kind === '2d' ? {...options, ...kPlane} : options);
  }
  prototype.getContext = /** @type {typeof original} */ (plane);
  try {
    return make();
  } finally {
    prototype.getContext = original;
  }
}
