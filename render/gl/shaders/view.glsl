// A recorded view.
struct View {
  vec4 row0, row1, row2;  // view_from_cam, 3x4
  vec4 intrinsics;        // fx fy cx cy
  vec4 size;              // width, height, feather in pixels, limit of the distortion (r^2, or theta)
  vec4 k;                 // k1 k2 p1 p2, or k1 k2 k3 k4
  vec4 more;              // k3, black, scale, distortion: 0 none, 1 radial-tangential, 2 fisheye
  vec4 color;             // in pictures of the blending field; w: with CORRECTED falloff_r4
  vec4 center;            // of the view; w: 1 where its photograph has pixels without light
  vec4 shadow_map;        // fx fy cx cy of its shadow map, for a map of size 1
  ivec4 place;            // texture array (-1: none), layer, layer of the depth map, layer of the shadow map (-1: none)
#ifdef CORRECTED
  vec4 correction;  // 1 / gain R G B, falloff_r2
#endif
};
struct DepthMap {
  vec4 intrinsics;  // fx fy cx cy, of the map's pixels
  vec4 more;        // width, height, the largest inverse depth, step
};
#ifdef ONE_CAMERA
uniform vec4 intrinsics, size, k, shadow_map;  // of all views
uniform vec4 to_uv;                            // from (x, y) / z to a photograph of size 1: scale, offset
uniform vec4 more;                             // of all views, with ONE_EXPOSURE
#endif
#ifdef ONE_EXPOSURE
uniform vec4 light;  // from (x, y) of a photograph of size 1 to feathers; black, scale
#endif
