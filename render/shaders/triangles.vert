// Triangles of the mesh of viewpoints, or of the image; drawn without depth, each where all its w are taken as they
// come: clipping leaves what is before the camera.
layout(location = 0) in vec3 position;  // clip x, y, w
layout(location = 1) in uint triangle_index;
flat out uint triangle;

void main() {
  triangle = triangle_index;
  gl_Position = vec4(position.xy, 0.0, position.z);
}
