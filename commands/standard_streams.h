// Lets the program continue when nobody takes its output: when the reader of a pipe is gone (EPIPE), the disk
// of a log is full (ENOSPC), the terminal has hung up (EIO) or is stopped, or a descriptor was closed from
// the start. The guard works below `stdout`, `stderr`, std::cout and std::cerr, so that it covers every way
// of writing to them (fmt::print, stdio, iostreams, spdlog) in every thread, and writes by libraries.
#pragma once

namespace ulf::commands {

// Opens /dev/null for each of the descriptors 0 to 2 that is closed; otherwise a file opened later would take
// the number, and messages would be written into it. May run before the constructors of libraries.
void FillStandardDescriptors();

// Makes all later writes to `stdout` and `stderr` succeed for their callers, without exceptions or SIGPIPE.
// Text for standard error that cannot be written is dropped, after a second if nobody reads. The first
// failure of standard output is kept for FlushStandardOutput(). Call it in main(), before a thread starts.
void GuardStandardStreams();

// Writes what is buffered for standard output. Returns 0 if all output of the process was written, else the
// errno of the first failure.
int FlushStandardOutput();

}  // namespace ulf::commands
