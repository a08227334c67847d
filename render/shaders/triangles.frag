// One pass per triangle: barycentric coordinates of the ray, then every view that weighs in this triangle.
struct Cone { vec4 row0, row1, row2; };  // barycentric_from_ray up to scale; w: confidence, first entry, count
layout(std430, binding = 1) readonly buffer Cones { Cone cones[]; };
// A view's weight at the three corners; x: index of the vertex whose view it is.
layout(std430, binding = 2) readonly buffer Entries { vec4 entries[]; };
layout(std430, binding = 3) readonly buffer ViewOfVertex { int view_of_vertex[]; };

flat in uint triangle;
out vec4 color;

void main() {
  vec3 ray = RayOfPixel();
  vec4 row0 = cones[triangle].row0, row1 = cones[triangle].row1, row2 = cones[triangle].row2;
  vec3 lambda = max(vec3(dot(row0.xyz, ray), dot(row1.xyz, ray), dot(row2.xyz, ray)), 0.0);
  vec3 barycentric = lambda / max(lambda.x + lambda.y + lambda.z, 1e-30);
  vec3 point = ray * DepthOf(ray);
  vec3 light = vec3(0.0);
  float sum = 0.0;
  int first = floatBitsToInt(row1.w), end = first + floatBitsToInt(row2.w);
  for (int e = first; e < end; ++e) {
    float weight = dot(barycentric, entries[e].yzw);
    if (weight <= 0.0) continue;
    int i = view_of_vertex[floatBitsToInt(entries[e].x)];
    vec2 img;
    weight *= See(i, point, img);
    if (weight <= 0.0) continue;
    light += weight * LightOf(i, img);
    sum += weight;
  }
  color = Normalised(light, sum, row0.w);
}
