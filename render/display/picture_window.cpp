#include "render/display/picture_window.h"

#include <variant>

#include "render/display/painter.h"

namespace ulf::render {

PictureWindow::PictureWindow(const std::string& title) : surface_(OpenWindow(title, {960, 720})) {}

bool PictureWindow::Show(const cv::Mat& srgb8) {
  bool goes_on = true;
  for (const InputEvent& event : surface_->TakeEvents(0)) {
    const auto* key = std::get_if<KeyPressed>(&event);
    const auto* typed = std::get_if<Typed>(&event);
    if (std::holds_alternative<CloseAsked>(event) || (key && key->key == Key::kEscape) ||
        (typed && typed->character == U'q'))
      goes_on = false;
    if (key && key->key == Key::kF11) surface_->ToggleFullScreen();
  }
  const cv::Size screen = surface_->Size();
  if (screen.empty()) return goes_on;  // iconified
  surface_->Bind();
  texture_.Upload(srgb8);
  texture_.FillScreen(Placement::Letterboxed(srgb8.size(), screen).Area(), screen, {0, 0, 0});
  surface_->Present();
  return goes_on;
}

}  // namespace ulf::render
