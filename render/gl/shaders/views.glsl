const int VIEW_TEXELS = 14;
// Texels: software rasterisers read them for all fragments together, and storage buffers for one fragment at
// a time.
layout(binding = 9) uniform samplerBuffer view_texels;

View ViewAt(int i) {
  int first = VIEW_TEXELS * i;
  View v;
  v.row0 = texelFetch(view_texels, first);
  v.row1 = texelFetch(view_texels, first + 1);
  v.row2 = texelFetch(view_texels, first + 2);
#ifdef ONE_CAMERA
  v.intrinsics = intrinsics;
  v.size = size;
  v.k = k;
  v.shadow_map = shadow_map;
#else
  v.intrinsics = texelFetch(view_texels, first + 3);
  v.size = texelFetch(view_texels, first + 4);
  v.k = texelFetch(view_texels, first + 5);
  v.shadow_map = texelFetch(view_texels, first + 9);
#endif
#ifdef ONE_EXPOSURE
  v.more = more;
#else
  v.more = texelFetch(view_texels, first + 6);
#endif
  v.color = texelFetch(view_texels, first + 7);
  v.center = texelFetch(view_texels, first + 8);
  v.place = ivec4(texelFetch(view_texels, first + 10));
#ifdef CORRECTED
  v.correction = texelFetch(view_texels, first + 11);
#endif
  return v;
}

DepthMap DepthMapAt(int i) {
  int first = VIEW_TEXELS * i + 12;
  return DepthMap(texelFetch(view_texels, first), texelFetch(view_texels, first + 1));
}
