// The proxy's triangles for one camera (its frame: x right, y down, z forward; row 0 of the target is the
// image's top).
layout(std430, binding = 6) readonly buffer Vertices { float vertices[]; };
layout(std430, binding = 7) readonly buffer Corners { uint corners[]; };
uniform vec4 row0, row1, row2;    // cam_from_world
uniform vec4 clip_x, clip_y;      // scale, offset
uniform float near;

void main() {
  uint at = 3u * corners[gl_VertexID];
  vec4 h = vec4(vertices[at], vertices[at + 1u], vertices[at + 2u], 1.0);
  vec3 q = vec3(dot(row0, h), dot(row1, h), dot(row2, h));
  gl_Position = vec4(clip_x.x * q.x + clip_x.y * q.z, clip_y.x * q.y + clip_y.y * q.z, near, q.z);
}
