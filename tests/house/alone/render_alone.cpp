// The renderer without a camera library: linked with all of ulf_render and nothing else.
#include <cstdio>
#include <exception>
#include <memory>

#include "render/gl/gl_renderer.h"
#include "render/renderer/renderer.h"
#include "tests/support/floors.h"

int main() {
  try {
    ulf::MakeRenderer(std::make_shared<const ulf::RenderScene>(), {});
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 0;
  }
  std::printf("a scene without views was taken for one\n");
  return 1;
}
