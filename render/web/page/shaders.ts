// The shaders. Pictures of all views lie in one array of textures: linear light, and as alpha how much of the way from
// the view into the scene is open, 1 - the least inverse depth that the view still sees (1: everything; 0: masked).

/** Views of one draw: 16 kB of uniforms are there on every machine. */
export const mostViewsOfDraw = 170;
export const vectorsOfView = 6;
export const mostFilling = 16;

const head = `#version 300 es
precision highp float;
precision highp int;
precision highp sampler2DArray;
`;

const ofView = `
uniform sampler2DArray pictures;
uniform float masks;  // 1 where views' alpha hides something

// The light of a view for the point at \`inverse\` depth along the ray; alpha: how much it sees of it. Of the view: rows of
// its picture (of size 1) from this camera, with the translation; feathers' inverse widths, layer, the factor of inverse
// depths; scale and offset in the layer.
vec4 see(vec4 row0, vec4 row1, vec4 row2, vec4 more, vec4 place, vec3 ray, float inverse, out float feather) {
  vec3 p = vec3(dot(row0.xyz, ray), dot(row1.xyz, ray), dot(row2.xyz, ray)) + inverse * vec3(row0.w, row1.w, row2.w);
  float far = 1.0 / p.z;
  vec2 uv = p.xy * far;
  vec2 edge = min(uv, 1.0 - uv) * more.xy;
  feather = p.z > 0.0 ? clamp(min(edge.x, edge.y), 0.0, 1.0) : 0.0;
  vec4 light = textureLod(pictures, vec3(place.xy * uv + place.zw, more.z), 0.0);
  float nearness = min(inverse * far * more.w, 0.985);
  float seen = clamp((nearness - 1.0 + light.a) * 255.0 + 1.0, 0.0, 1.0);
  return vec4(light.rgb, feather * mix(1.0, seen, masks));
}

vec3 srgb(vec3 light) {
  // Within 0.2 levels of 255 of the exact curve.
  vec3 a = sqrt(clamp(light, 0.0, 1.0)), b = sqrt(a), c = sqrt(b);
  return 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * a * a;
}
`;

const ofViews = `
// Of each view what see() wants, and its centre in this camera.
layout(std140) uniform Views { vec4 views[${mostViewsOfDraw * vectorsOfView}]; };
vec4 seeView(int v, vec3 ray, float inverse, out float feather) {
  int at = ${vectorsOfView} * v;
  return see(views[at], views[at + 1], views[at + 2], views[at + 3], views[at + 4], ray, inverse, feather);
}
`;

const ofPixel = `
uniform vec4 camera;         // half of the width and height, 1 / focal length, 1 / near
uniform vec4 plane;          // normal . ray = offset / depth: normal / offset, and the least inverse depth
uniform float focusInverse;  // above 0: of the focal plane, in place of everything
uniform float holesScale;    // above 0: inverse depths in \`holes\`
uniform highp sampler2D nearness;  // 1 - near / depth; 1 without a triangle
uniform highp sampler2D holes;

vec3 rayOfPixel() { return vec3((gl_FragCoord.xy - camera.xy) * vec2(camera.z, -camera.z), 1.0); }

float inverseDepth(vec3 ray) {
  if (focusInverse > 0.0) return focusInverse;
  float far = texelFetch(nearness, ivec2(gl_FragCoord.xy), 0).r;
  float inverse = (1.0 - far) * camera.w;
  if (far >= 1.0) {
    inverse = holesScale > 0.0 ? texture(holes, 0.5 * gl_FragCoord.xy / camera.xy).r * holesScale : 0.0;
    if (inverse <= 0.0) inverse = max(dot(plane.xyz, ray), plane.w);
  }
  return inverse;
}
`;

/** A triangle of the blending field. */
export const fieldVertex = `${head}
uniform vec4 corners[3];  // of clip space
void main() { gl_Position = corners[gl_VertexID]; }`;

/**
 * The light of a triangle's views, by their weights; alpha: 1 where they see enough of the point, less where others have to
 * fill in. Views are uniforms, since software drawing takes up to twice as long with numbers that might differ between pixels.
 */
export const fieldFragment = (most: number): string => `${head}${ofView}${ofPixel}
uniform vec4 own[${vectorsOfView * most}];  // of each view what see() wants, and the numerator of its weight
uniform vec3 denominator;
out vec4 color;

void main() {
  vec3 ray = rayOfPixel();
  float inverse = inverseDepth(ray);
  vec4 all = vec4(0.0);
  float feather;
${Array.from({ length: most }, (_, n) => {
    const at = (k: number): string => `own[${vectorsOfView * n + k}]`;
    return `  {
    vec4 light = see(${[0, 1, 2, 3, 4].map(at).join(", ")}, ray, inverse, feather);
    float weight = max(dot(${at(5)}.xyz, ray), 0.0) * light.a;
    all += vec4(light.rgb * weight, weight);
  }`;
  }).join("\n")}
  float share = clamp(2.0 * all.a / max(dot(denominator, ray), 1e-30), 0.0, 1.0);
  color = vec4(srgb(all.rgb / max(all.a, 1e-30)), share);
}`;

/** Tiles of the picture in which some pixel is not finished. */
export const tilePx = 16;
export const openTilesFragment = `${head}
uniform sampler2D drawn;
out vec4 color;
void main() {
  ivec2 first = ${tilePx} * ivec2(gl_FragCoord.xy), last = textureSize(drawn, 0) - 1;
  float least = 1.0;
  for (int y = 0; y < ${tilePx}; ++y)
    for (int x = 0; x < ${tilePx}; ++x) least = min(least, texelFetch(drawn, min(first + ivec2(x, y), last), 0).a);
  color = vec4(least < 0.996 ? 1.0 : 0.0);
}`;

/** A square of each such tile, and nothing of the others: software drawing takes as long for a branch not taken. */
export const fillVertex = `${head}
uniform sampler2D openTiles;
uniform vec4 camera;  // half of the width and height
void main() {
  const ivec2 corners[6] = ivec2[6](ivec2(0, 0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1, 1));
  int columns = textureSize(openTiles, 0).x;
  ivec2 tile = ivec2(gl_InstanceID % columns, gl_InstanceID / columns);
  vec2 corner = vec2(${tilePx} * (tile + corners[gl_VertexID])) / camera.xy - 1.0;
  gl_Position = texelFetch(openTiles, tile, 0).r > 0.5 ? vec4(corner, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
}`;

/** Views fill in, nearest first, where the field's own see hardly anything. */
export const fillFragment = `${head}${ofView}${ofViews}${ofPixel}
uniform sampler2D drawn;
uniform int filling;
uniform vec3 ground;  // where there is no light
out vec4 color;

void main() {
  color = texelFetch(drawn, ivec2(gl_FragCoord.xy), 0);
  bool finished = color.a >= 0.996;
  float most = finished ? 1.0 : 0.5 * color.a;  // the clearest view of the point
  vec4 others = vec4(0.0), hidden = vec4(0.0);
  vec3 ray = rayOfPixel();
  float inverse = inverseDepth(ray);
  vec3 point = ray / inverse;
  int count = 0;
  for (int n = 0; n < filling && count < 4 && !finished; ++n) {
    float feather;
    vec4 light = seeView(n, ray, inverse, feather);
    if (feather <= 0.0) continue;
    most = max(most, feather);
    if (hidden.a == 0.0) hidden = vec4(light.rgb * feather, feather);
    if (light.a <= 0.0) continue;
    vec3 toView = views[${vectorsOfView} * n + 5].xyz - point;
    float penalty = acos(clamp(dot(-point, toView) * inversesqrt(dot(point, point) * dot(toView, toView)), -1.0, 1.0));
    float weight = light.a / max(penalty, 1e-3);
    others += vec4(light.rgb * weight, weight);
    ++count;
  }
  if (others.a <= 0.0) others = hidden;
  if (others.a > 0.0) color.rgb = mix(srgb(others.rgb / others.a), color.rgb, color.a);
  float there = color.a + others.a > 0.0 ? clamp(most, 0.0, 1.0) : 0.0;
  color = vec4(mix(ground, color.rgb, there), 1.0);
}`;

/** The whole picture at once. */
export const screenVertex = `${head}
uniform float depth;
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, depth, 1.0); }`;

/** A wide aperture: every view counts by where its ray goes through the lens. */
export const apertureFragment = `${head}${ofView}${ofViews}${ofPixel}
uniform int count;
uniform float inverseRadius;
uniform vec3 ground;  // where there is no light
out vec4 color;

void main() {
  vec3 ray = rayOfPixel();
  float feather;
  vec4 all = vec4(0.0);
  vec3 point = ray / focusInverse;
  for (int n = 0; n < count; ++n) {
    vec3 center = views[${vectorsOfView} * n + 5].xyz;
    vec2 through = mix(point.xy, center.xy, point.z / (point.z - center.z)) * inverseRadius;
    float from_middle = dot(through, through);
    if (from_middle >= 1.0 || center.z >= point.z) continue;
    vec4 light = seeView(n, ray, focusInverse, feather);
    float weight = (1.0 - from_middle) * (1.0 - from_middle) * feather;
    all += vec4(light.rgb * weight, weight);
  }
  color = vec4(all.a > 0.0 ? srgb(all.rgb / all.a) : ground, 1.0);
}`;

/** How near the triangles of the geometry are. */
export const depthVertex = `${head}
layout(location = 0) in vec3 place;
uniform vec3 low, step;
uniform vec4 row0, row1, row2;  // of the camera
uniform vec4 lens;              // to clip space: x scale, y scale, x offset, y offset
uniform float near;
void main() {
  vec4 h = vec4(low + step * place, 1.0);
  vec3 p = vec3(dot(row0, h), dot(row1, h), dot(row2, h));
  gl_Position = vec4(p.xy * lens.xy + p.z * lens.zw, p.z - 2.0 * near, p.z);
}`;
export const depthFragment = `${head}
void main() {}`;

/** The mean of the known among four: holes of the geometry are as deep as what is around them. */
export const pullFragment = `${head}
uniform highp sampler2D finer;
uniform bool ofNearness;
out vec4 color;
void main() {
  // The first level is a quarter of the picture, of one in four pixels: depths of holes are smooth.
  int apart = ofNearness ? 2 : 1;
  ivec2 size = textureSize(finer, 0), first = 2 * apart * ivec2(gl_FragCoord.xy);
  float total = 0.0, known = 0.0;
  for (int n = 0; n < 4; ++n) {
    ivec2 at = first + apart * ivec2(n & 1, n >> 1);
    if (any(greaterThanEqual(at, size))) continue;
    float value = texelFetch(finer, at, 0).r;
    if (ofNearness) value = 1.0 - value;
    if (value <= 0.0) continue;
    total += value;
    known += 1.0;
  }
  color = vec4(known > 0.0 ? total / known : 0.0);
}`;
export const pushFragment = `${head}
uniform highp sampler2D coarser, pulled;
out vec4 color;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float own = texelFetch(pulled, here, 0).r;
  ivec2 last = textureSize(coarser, 0) - 1, at = here / 2;
  ivec2 beside = clamp(at + 2 * (here & 1) - 1, ivec2(0), last);
  float around = (9.0 * texelFetch(coarser, at, 0).r + 3.0 * texelFetch(coarser, ivec2(beside.x, at.y), 0).r +
                  3.0 * texelFetch(coarser, ivec2(at.x, beside.y), 0).r + texelFetch(coarser, beside, 0).r) / 16.0;
  color = vec4(own > 0.0 ? own : around);
}`;

/** From which depth on a view sees nothing (render/proxy/shadow_map.h), times the view's factor. */
export const hidesFragment = `${head}
uniform highp sampler2D nearness;
uniform float scale;  // to the view's factor
out vec4 color;
float at(ivec2 place) {
  ivec2 size = textureSize(nearness, 0);
  if (any(lessThan(place, ivec2(0))) || any(greaterThanEqual(place, size))) return 0.0;
  return 1.0 - texelFetch(nearness, place, 0).r;
}
float slope(float before, float here, float behind) {
  float back = before > 0.0 ? abs(here - before) : -1.0, on = behind > 0.0 ? abs(behind - here) : -1.0;
  if (back < 0.0 || on < 0.0) return max(max(back, on), 0.0);
  return max(back, on) < 0.1 * here ? max(back, on) : min(back, on);
}
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float value = at(here);
  float change = slope(at(here - ivec2(1, 0)), value, at(here + ivec2(1, 0))) +
                 slope(at(here - ivec2(0, 1)), value, at(here + ivec2(0, 1)));
  float least = value > 0.0 ? max(0.0, 0.99 * value - 2.0 * change) : 0.0;
  color = vec4(floor(min(least * scale, 0.98) * 255.0) / 255.0);
}`;
/** A photograph mixes both sides of an edge within a texel: that texel is hidden, too. */
export const widenFragment = `${head}
uniform highp sampler2D narrow;
out vec4 color;
void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(narrow, 0) - 1;
  float most = 0.0;
  for (int n = 0; n < 9; ++n)
    most = max(most, texelFetch(narrow, clamp(here + ivec2(n % 3, n / 3) - 1, ivec2(0), last), 0).r);
  color = vec4(most);
}`;
/** Multiplied onto the alpha of a view's picture. */
export const openFragment = `${head}
uniform highp sampler2DArray hides;
uniform vec4 area;  // of the picture in its layer: offset, 1 / size
uniform float layer;
out vec4 color;
void main() {
  color = vec4(0.0, 0.0, 0.0, 1.0 - texture(hides, vec3((gl_FragCoord.xy - area.xy) * area.zw, layer)).r);
}`;
