// The GenICam description (GenApi XML, schema 1.0) of the simulated camera. Its addresses are the registers
// of Aravis's fake camera and of gige_registers.h.
#pragma once

#include <string>

namespace ulf::acquisition {

// Generated once per process.
const std::string& GenicamDescription();

// The description in a temporary file, as long as this object lives: Aravis reads it from one.
class GenicamDescriptionFile {
 public:
  GenicamDescriptionFile();
  ~GenicamDescriptionFile();
  GenicamDescriptionFile(const GenicamDescriptionFile&) = delete;
  GenicamDescriptionFile& operator=(const GenicamDescriptionFile&) = delete;
  const char* path() const { return path_.c_str(); }

 private:
  std::string path_;
};

}  // namespace ulf::acquisition
