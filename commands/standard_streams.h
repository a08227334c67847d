// Standard input, output and error of a program that must go on when nobody reads what it says: the reader of
// a pipe is gone (EPIPE), the disk of a log is full (ENOSPC), the terminal has hung up (EIO) or stands still,
// the descriptor was closed from the start. The guard stands behind `stdout`, `stderr`, std::cout and
// std::cerr themselves, so that it holds for every way of writing to them (fmt::print, stdio, iostreams,
// spdlog) in every thread, and for what libraries write.
#pragma once

namespace ulf::commands {

// Opens /dev/null in place of each of the descriptors 0 to 2 that is closed; otherwise a file that is opened
// later takes the number, and messages are written into it. May run before the constructors of libraries.
void FillStandardDescriptors();

// From here on no write to `stdout` or `stderr` fails, throws or raises SIGPIPE. What standard error does not
// take is lost, at once or after a second where nobody reads. What standard output does not take is
// remembered. For main(), before it starts a thread.
void GuardStandardStreams();

// Writes what is buffered. Returns 0 where standard output has taken everything, else the errno of the first
// failure.
int FlushStandardOutput();

}  // namespace ulf::commands
