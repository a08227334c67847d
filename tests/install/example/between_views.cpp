// between_views FOLDER PICTURE.png: what a camera sees halfway between the first two viewpoints of
// a light field.
#include <cstdio>
#include <exception>

#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "render/gl/gl_renderer.h"

int main(int argc, char** argv) {
  if (argc != 3) return std::fputs("usage: between_views FOLDER PICTURE.png\n", stderr), 2;
  try {
    const ulf::LightField light_field = ulf::ReadLightField(argv[1]);
    const ulf::Rigid3 between =
        Interpolated(light_field.views.at(0).cam_from_world, light_field.views.at(1).cam_from_world, 0.5);

    const auto scene = ulf::render::LoadScene(light_field, {});
    const auto renderer =
        ulf::render::MakeRenderer(scene, {.renderer = ulf::render::RendererKind::kReference});
    const ulf::CameraModel camera = light_field.cameras.at(0).WithoutDistortion();
    const auto picture = renderer->Render(camera, between);
    ulf::WritePictureFile(argv[2], ulf::Srgb8FromLinear(picture.linear));
    std::printf("%d x %d, %ld pixels empty\n", picture.linear.cols, picture.linear.rows, picture.empty_px);
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "between_views: %s\n", error.what()), 1;
  }
}
