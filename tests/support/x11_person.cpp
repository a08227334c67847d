#include "tests/support/x11_person.h"

#include <chrono>
#include <thread>

#include "core/base/error.h"
// Its macros come last.
#include <X11/Xlib.h>
#include <X11/Xutil.h>

namespace ulf::test {
namespace {

Display* Of(void* display) { return static_cast<Display*>(display); }

unsigned long FindWindow(Display* display, unsigned long below, const std::string& title) {
  char* name = nullptr;
  if (XFetchName(display, below, &name) && name) {
    const bool found = title == name;
    XFree(name);
    if (found) return below;
  }
  ::Window root = 0, parent = 0, *children = nullptr;
  unsigned count = 0;
  unsigned long found = 0;
  if (!XQueryTree(display, below, &root, &parent, &children, &count)) return 0;
  for (unsigned i = 0; i < count && !found; ++i) found = FindWindow(display, children[i], title);
  if (children) XFree(children);
  return found;
}

// Windows come and go while they are looked through.
int Ignore(Display*, XErrorEvent*) { return 0; }

// A server that has told its number may take a moment more on a busy machine.
Display* OpenSoon(const char* name) {
  for (int tries = 0; tries < 50; ++tries) {
    if (Display* display = XOpenDisplay(name)) return display;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  return nullptr;
}

}  // namespace

X11Person::X11Person(const std::string& title, const std::string& display)
    : display_(OpenSoon(display.empty() ? nullptr : display.c_str())) {
  if (!display_) throw Error("there is no X11 display; start the test under xvfb-run");
  // Where the test is the window's program, too, that one's handler comes back.
  const auto before = XSetErrorHandler(nullptr), xlibs_own = XSetErrorHandler(Ignore);
  for (int i = 0; i < 300 && !window_; ++i) {
    window_ = FindWindow(Of(display_), DefaultRootWindow(Of(display_)), title);
    if (!window_) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
  if (before != xlibs_own) XSetErrorHandler(before);
  if (!window_) throw Error("no window '{}' has come", title);
}

X11Person::~X11Person() { XCloseDisplay(Of(display_)); }

void X11Person::Press(const std::string& keysym) {
  XEvent event{};
  event.xkey.display = Of(display_);
  event.xkey.window = window_;
  event.xkey.root = DefaultRootWindow(Of(display_));
  event.xkey.same_screen = True;
  event.xkey.keycode = XKeysymToKeycode(Of(display_), XStringToKeysym(keysym.c_str()));
  for (const int type : {KeyPress, KeyRelease}) {
    event.xkey.type = type;
    XSendEvent(Of(display_), window_, True, NoEventMask, &event);
  }
  XFlush(Of(display_));
}

void X11Person::MoveMouse(int x, int y) {
  x_ = x, y_ = y;
  XEvent event{};
  event.xmotion.type = MotionNotify;
  event.xmotion.window = window_;
  event.xmotion.x = x;
  event.xmotion.y = y;
  event.xmotion.same_screen = True;
  XSendEvent(Of(display_), window_, True, NoEventMask, &event);
  XFlush(Of(display_));
}

void X11Person::Click(int button) {
  XEvent event{};
  event.xbutton.window = window_;
  event.xbutton.x = x_;
  event.xbutton.y = y_;
  event.xbutton.button = static_cast<unsigned>(button);
  event.xbutton.same_screen = True;
  for (const int type : {ButtonPress, ButtonRelease}) {
    event.xbutton.type = type;
    XSendEvent(Of(display_), window_, True, NoEventMask, &event);
  }
  XFlush(Of(display_));
}

void X11Person::CloseWindow() {
  XEvent event{};
  event.xclient.type = ClientMessage;
  event.xclient.window = window_;
  event.xclient.message_type = XInternAtom(Of(display_), "WM_PROTOCOLS", False);
  event.xclient.format = 32;
  event.xclient.data.l[0] = static_cast<long>(XInternAtom(Of(display_), "WM_DELETE_WINDOW", False));
  event.xclient.data.l[1] = CurrentTime;
  XSendEvent(Of(display_), window_, False, NoEventMask, &event);
  XFlush(Of(display_));
}

void X11Person::DestroyWindow() {
  XDestroyWindow(Of(display_), window_);
  XFlush(Of(display_));
}

void X11Person::KillClient() {
  XKillClient(Of(display_), window_);
  XFlush(Of(display_));
}

}  // namespace ulf::test
