// First pass: the last of the triangles at a pixel (by its depth), and its confidence.
invariant gl_Position;
flat out float confidence;

void main() {
  uint triangle = uint(gl_VertexID) / 3u;
  confidence = triangles[triangle].row[0].w;
  gl_Position = ClipPosition(triangle, uint(gl_VertexID) % 3u);
}
