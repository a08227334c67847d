// Guards standard input, output and error of a program that must continue if nobody reads its output: the
// reader of a pipe is gone (EPIPE), the disk of a log is full (ENOSPC), the terminal has hung up (EIO) or is
// stopped, the descriptor was closed from the start. The guard is installed below `stdout`, `stderr`,
// std::cout and std::cerr, so that it covers every way of writing to them (fmt::print, stdio, iostreams,
// spdlog) in every thread, and writes by libraries.
#pragma once

namespace ulf::commands {

// Opens /dev/null in place of each of the descriptors 0 to 2 that is closed; otherwise a file that is opened
// later takes the number, and messages are written into it. May run before the constructors of libraries.
void FillStandardDescriptors();

// From here on no write to `stdout` or `stderr` fails, throws or raises SIGPIPE. Standard error that cannot
// be written is lost, at once or after a second if nobody reads. Failures of standard output are remembered.
// Call it in main(), before a thread starts.
void GuardStandardStreams();

// Writes what is buffered. Returns 0 if standard output has taken everything, else the errno of the first
// failure.
int FlushStandardOutput();

}  // namespace ulf::commands
