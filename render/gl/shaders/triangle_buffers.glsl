// Triangles of the viewpoint mesh or of the image. Their depth is their order, so that of overlapping
// triangles the last one counts.
struct Triangle {
  vec4 corner[3];  // clip x, y, depth between -1 and 1, w
  vec4 row[3];     // barycentric_from_ray up to scale; the first's w: confidence
};
layout(std430, binding = 1) readonly buffer Triangles { Triangle triangles[]; };

// Clipping keeps what is in front of the camera: w > 0.
vec4 ClipPosition(uint triangle, uint corner) {
  vec4 c = triangles[triangle].corner[corner];
  return vec4(c.xy, c.z * c.w, c.w);
}
