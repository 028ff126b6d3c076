// The shading programs of the WebGL renderer.

const VERTEX = `#version 300 es
layout(location = 0) in vec3 place;
layout(location = 1) in vec3 normal;
uniform mat4 world, view, shade;
out vec3 at, facing;
out vec4 inLight;
void main() {
  vec4 moved = world * vec4(place, 1.0);
  at = moved.xyz;
  facing = mat3(world) * normal;
  inLight = shade * moved;
  gl_Position = view * moved;
}`;

/** Light of the sky, a lamp with shadow, and highlights by the model of Cook and Torrance. */
const LIT = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
in vec3 at, facing;
in vec4 inLight;
uniform vec3 eye, light, sky, ground, lamp, colour, emitted;
uniform float roughness, metal, opacity, shadowed;
uniform sampler2DShadow shadows;
out vec4 pixel;
float litPart(vec3 n) {
  vec3 spot = inLight.xyz * 0.5 + 0.5;
  if (any(lessThan(spot, vec3(0.0))) || any(greaterThan(spot, vec3(1.0)))) return 1.0;
  spot.z -= 0.0006 + 0.002 * (1.0 - max(0.0, dot(n, light)));
  vec2 texel = 1.0 / vec2(textureSize(shadows, 0));
  float sum = 0.0;
  for (int i = -1; i <= 1; i += 1)
    for (int k = -1; k <= 1; k += 1) sum += texture(shadows, vec3(spot.xy + 1.1 * vec2(i, k) * texel, spot.z));
  return mix(1.0, sum / 9.0, shadowed);
}
void main() {
  vec3 n = normalize(facing), v = normalize(eye - at), h = normalize(light + v);
  if (!gl_FrontFacing) n = -n;
  float nl = max(dot(n, light), 0.0), nv = max(dot(n, v), 1e-3), nh = max(dot(n, h), 0.0), vh = max(dot(v, h), 0.0);
  float a = roughness * roughness, a2 = a * a;
  float spread = a2 / (3.14159 * pow(nh * nh * (a2 - 1.0) + 1.0, 2.0));
  float k = a * 0.5;
  float visible = 1.0 / (4.0 * (nl * (1.0 - k) + k) * (nv * (1.0 - k) + k));
  vec3 base = mix(vec3(0.04), colour, metal);
  vec3 fresnel = base + (1.0 - base) * pow(1.0 - vh, 5.0);
  vec3 around = mix(ground, sky, n.z * 0.5 + 0.5);
  vec3 mirrored = mix(ground, sky * 1.25, smoothstep(-0.25, 0.55, reflect(-v, n).z));
  vec3 rim = base + (max(vec3(1.0 - roughness), base) - base) * pow(1.0 - nv, 5.0);
  vec3 diffuse = colour * (1.0 - metal);
  vec3 lit = (diffuse + spread * visible * fresnel * 3.14159) * lamp * nl * litPart(n);
  vec3 sum = lit + diffuse * around + rim * mirrored * (1.0 - 0.6 * roughness) + emitted;
  sum = sum / (1.0 + max(0.0, max(sum.r, max(sum.g, sum.b)) - 0.8));
  pixel = vec4(pow(sum, vec3(1.0 / 2.2)) * opacity, opacity);
}`;

/** The floor: a grid that fades with the distance, the shadow of the arm, and the sky behind. */
const FLOOR = `#version 300 es
precision highp float;
precision highp sampler2DShadow;
in vec3 at, facing;
in vec4 inLight;
uniform vec3 eye, line;
uniform float cell, reach, shadowed, darkness;
uniform sampler2DShadow shadows;
out vec4 pixel;
float lines(float size, float width) {
  vec2 spot = at.xy / size, wide = fwidth(spot) * width;
  vec2 near = abs(fract(spot - 0.5) - 0.5) / max(wide, 1e-6);
  float fade = 1.0 - smoothstep(0.2, 0.7, max(wide.x, wide.y));
  return (1.0 - min(min(near.x, near.y), 1.0)) * fade;
}
void main() {
  float away = length(at.xy) / reach;
  float fade = 1.0 - smoothstep(0.35, 1.0, away);
  vec2 axis = abs(at.xy) / max(fwidth(at.xy), 1e-6);
  float grid = max(0.34 * lines(cell, 1.0), 0.18 * lines(cell * 0.2, 0.8) * (1.0 - smoothstep(0.1, 0.5, away)));
  grid = max(grid, 0.45 * (1.0 - min(min(axis.x, axis.y), 1.0)));
  vec3 spot = inLight.xyz * 0.5 + 0.5;
  vec2 texel = 1.0 / vec2(textureSize(shadows, 0));
  float dark = 0.0;
  if (all(greaterThan(spot, vec3(0.0))) && all(lessThan(spot, vec3(1.0)))) {
    for (int i = -2; i <= 2; i += 1)
      for (int k = -2; k <= 2; k += 1) dark += 1.0 - texture(shadows, vec3(spot.xy + 1.6 * vec2(i, k) * texel, spot.z - 0.001));
    dark *= shadowed * darkness / 25.0;
  }
  float under = eye.z < 0.0 ? 0.25 : 1.0;
  float veil = dark + grid * (1.0 - dark);
  pixel = vec4(line * grid * (1.0 - dark) * fade * under, veil * fade * under);
}`;

const SKY_VERTEX = `#version 300 es
layout(location = 0) in vec3 place;
out vec2 spot;
void main() {
  spot = place.xy;
  gl_Position = vec4(place.xy, 0.99999, 1.0);
}`;

const SKY = `#version 300 es
precision highp float;
in vec2 spot;
uniform vec3 above, below;
out vec4 pixel;
void main() {
  float noise = fract(sin(dot(gl_FragCoord.xy, vec2(12.9898, 78.233))) * 43758.5453) / 255.0;
  vec3 colour = mix(below, above, smoothstep(-1.0, 0.9, spot.y));
  colour += 0.035 * (1.0 - length(spot * vec2(0.7, 0.9)));
  pixel = vec4(colour + noise, 1.0);
}`;

/** Only depths, for the shadow and for translucent bodies. */
const DEPTH = `#version 300 es
precision highp float;
in vec3 at, facing;
out vec4 pixel;
void main() { pixel = vec4(0.0); }`;

/** One colour without light: paths. */
const PLAIN = `#version 300 es
precision highp float;
in vec3 at, facing;
uniform vec3 colour;
uniform float opacity;
out vec4 pixel;
void main() { pixel = vec4(colour * opacity, opacity); }`;

/** Sources of each program: of its corners, and of its pixels. */
export const SOURCES = /** @type {const} */ ({
  lit: [VERTEX, LIT], floor: [VERTEX, FLOOR], sky: [SKY_VERTEX, SKY], depth: [VERTEX, DEPTH], plain: [VERTEX, PLAIN],
});
