// Tiles of the image, and the views that their pixels go through.
struct Tile {
  vec4 clip;    // left, top, right, bottom
  ivec4 views;  // first and end
};
layout(std430, binding = 1) readonly buffer Tiles { Tile tiles[]; };
uniform float depth;
flat out ivec2 looks_through;

void main() {
  const int corners[6] = int[6](0, 1, 2, 2, 1, 3);
  Tile tile = tiles[gl_VertexID / 6];
  int corner = corners[gl_VertexID % 6];
  looks_through = tile.views.xy;
  gl_Position = vec4((corner & 1) == 0 ? tile.clip.x : tile.clip.z, (corner & 2) == 0 ? tile.clip.y : tile.clip.w, depth, 1.0);
}
