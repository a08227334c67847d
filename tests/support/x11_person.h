// Plays a person before an X11 window: sends it keys, mouse and its close button as events.
#pragma once

#include <string>

namespace ulf::test {

class X11Person {
 public:
  // Waits for a window of this title, on the display of the environment or the one named; throws Error when
  // none comes within half a minute.
  explicit X11Person(const std::string& title, const std::string& display = "");
  ~X11Person();
  X11Person(const X11Person&) = delete;
  X11Person& operator=(const X11Person&) = delete;

  void Press(const std::string& keysym);  // X11's name: "q", "Left", "space"
  void MoveMouse(int x, int y);
  void Click(int button);  // 1 left, 3 right, 4 and 5 the wheel
  void CloseWindow();
  // Ends the window, or the program that has it, as other programs can without asking.
  void DestroyWindow();
  void KillClient();

 private:
  void* display_;
  unsigned long window_ = 0;
  int x_ = 0, y_ = 0;
};

}  // namespace ulf::test
