// Chooses how the scene is drawn: with WebGL 2 on a graphics card, else on a two-dimensional canvas.

import { SolidScene } from './solid_scene.js';

/** Names of renderers that use no graphics card. */
const SOFTWARE = /swiftshader|llvmpipe|softpipe|software|basic render/i;

/** @type {(gl: WebGL2RenderingContext) => boolean} */
function isSoftware(gl) {
  const about = gl.getExtension('WEBGL_debug_renderer_info');
  return SOFTWARE.test(String(gl.getParameter(about?.UNMASKED_RENDERER_WEBGL ?? gl.RENDERER)));
}

/**
 * Returns the WebGL scene; null if it is not available or would be drawn without a graphics card. `?renderer=webgl` and
 * `?renderer=canvas` in the address choose by hand.
 * @type {(canvas: HTMLCanvasElement, onLost: () => void) => SolidScene | null}
 */
export function solidScene(canvas, onLost) {
  const wanted = new URLSearchParams(location.search).get('renderer');
  if (wanted === 'canvas') return null;
  const gl = canvas.getContext('webgl2', {
    alpha: false, antialias: true, powerPreference: 'high-performance', failIfMajorPerformanceCaveat: wanted !== 'webgl',
  });
  if (!gl || (wanted !== 'webgl' && isSoftware(gl))) return null;
  canvas.addEventListener('webglcontextlost', onLost);
  try {
    return new SolidScene(gl);
  } catch (error) {
    console.warn(error);
    return null;
  }
}
