// capture_and_render DEVICE FOLDER PICTURE.png: records views of a subject until a cap of 30 x 20 degrees
// around it is covered, says where the next viewpoint would be, and renders over the captured geometry what a
// camera sees halfway between the first two views. DEVICE is a simulated camera, such as sim:studio, which
// knows its poses: features would be tracked otherwise.
#include <cstdio>
#include <exception>

#include "core/base/error.h"
#include "core/image/files/picture_file.h"
#include "core/light_field/folder/light_field_io.h"
#include "coverage/bound/guidance.h"
#include "coverage/session/capture_session.h"
#include "coverage/session/prepared_capture.h"
#include "render/gl/gl_renderer.h"
#include "render/proxy/proxy_choice.h"

int main(int argc, char** argv) {
  if (argc != 4) return std::fputs("usage: capture_and_render DEVICE FOLDER PICTURE.png\n", stderr), 2;
  try {
    ulf::coverage::SessionArgs session;
    session.uri = argv[1];
    session.dir = argv[2];
    session.poses = ulf::tracking::PosesSpec::Parse("known");
    ulf::coverage::CaptureOptions options;
    options.subject =
        ulf::ParseSubject("0,0,0.07,0.162");  // of the simulated studio: centre and radius, metres
    options.cap = ulf::coverage::Cap::FromDegrees({30, 20});
    options.threshold_px = ulf::coverage::kFastThresholdPx;
    options.geometry = true;

    // The device, its lens, the source of poses and the folder fit together, or an error says what does not.
    ulf::coverage::PreparedCapture capture;
    if (!PrepareCapture(session, &options, capture)) return 1;
    const ulf::coverage::CaptureSummary summary =
        RunCapture(*capture.device, capture.camera, *capture.poses, std::move(*capture.writer), options, {},
                   std::move(capture.first));
    std::printf("%d views cover %.0f %% of the cap\n", static_cast<int>(summary.recorded),
                100 * summary.map->CoveredShare());

    const auto next = ulf::coverage::Guide(1).Update(summary.map.get(), {}, 0);
    if (next.toward)
      std::printf("the next view: %.2f, %.2f, %.2f from the subject\n", next.toward->x(), next.toward->y(),
                  next.toward->z());

    const ulf::LightField light_field = ulf::ReadLightField(session.dir);
    if (light_field.views.size() < 2)
      throw ulf::Error("{}: holds fewer than two views; let the camera go on for longer", session.dir);
    const ulf::Rigid3 between =
        Interpolated(light_field.views.at(0).cam_from_world, light_field.views.at(1).cam_from_world, 0.5);
    const auto over_plane = ulf::render::LoadScene(light_field, {});
    const auto proxy = ulf::render::OwnProxy(ulf::render::DefaultProxies(session.dir).front(),
                                             over_plane->subject, session.dir);
    const auto renderer = ulf::render::MakeRenderer(WithProxy(*over_plane, proxy),
                                                    {.renderer = ulf::render::RendererKind::kReference});
    const auto picture = renderer->Render(light_field.cameras.at(0).WithoutDistortion(), between);
    ulf::WritePictureFile(argv[3], ulf::Srgb8FromLinear(picture.linear));
  } catch (const std::exception& error) {
    return std::fprintf(stderr, "capture_and_render: %s\n", error.what()), 1;
  }
}
