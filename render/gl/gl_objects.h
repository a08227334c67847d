// The few OpenGL objects that the renderer needs, as thin as can be. All need their context to be current,
// also for Release().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace ulf::render {

// Of an array of textures: the driver's, and no more than a float tells beside another number of that size.
int MostLayers();

// Throws Error with OpenGL's error and what was being done.
void CheckGl(const char* doing);

class GlProgram {
 public:
  void Build(const std::string& name, const std::string& vertex_source, const std::string& fragment_source);
  void Use() const;
  // Names that the compiler dropped are passed over.
  void Set(const char* name, int value) const;
  void Set(const char* name, float value) const;
  void Set(const char* name, const std::array<float, 4>& value) const;
  void Release();

 private:
  unsigned program_ = 0;
};

class GlBuffer {
 public:
  template <typename T>
  void Upload(const std::vector<T>& values) {
    UploadBytes(values.data(), values.size() * sizeof(T));
  }
  void BindStorage(unsigned binding) const;
  unsigned name() const { return buffer_; }
  // What shaders wrote into it; waits for them.
  std::vector<std::int32_t> Read(std::size_t count) const;
  void Release();

 private:
  void UploadBytes(const void* data, std::size_t size);
  unsigned buffer_ = 0;
};

// Integers, or structs of vectors of four floats, that shaders fetch as texels.
class GlTexelBuffer {
 public:
  // Throws Error where they are more than the driver can address.
  template <typename T>
  void Upload(const std::vector<T>& values) {
    buffer_.Upload(values);
    Attach(values.size() * sizeof(T), std::is_integral_v<T>);
  }
  void Bind(unsigned unit) const;
  void Release();

 private:
  void Attach(std::size_t bytes, bool integers);

  unsigned texture_ = 0;
  GlBuffer buffer_;
};

// No attributes: every vertex is made up by its shader.
class GlEmptyVertexArray {
 public:
  void Bind();
  void Release();

 private:
  unsigned array_ = 0;
};

// Counts the pixels of what is drawn between Begin() and End() that reach the target.
class GlPixelCounter {
 public:
  void Begin();
  void End() const;
  std::uint64_t Count() const;  // waits for them
  void Release();

 private:
  unsigned query_ = 0;
};

// A depth buffer that several targets share.
class GlDepth {
 public:
  void Resize(int width, int height);
  unsigned name() const { return buffer_; }
  void Release();

 private:
  int width_ = 0, height_ = 0;
  unsigned buffer_ = 0;
};

// A float image to draw into.
class GlTarget {
 public:
  explicit GlTarget(unsigned format) : format_(format) {}  // GL_RGBA32F and so on
  void Resize(int width, int height, const GlDepth* depth = nullptr);
  void Bind() const;
  void Clear(float value) const;
  void Clear(const std::array<float, 4>& rgba) const;
  void ClearDepth(float value) const;  // 0 nearest to 1 farthest
  void BindTexture(unsigned unit) const;
  void CopyTo(const GlTarget& other) const;  // of the same size and format
  unsigned texture() const { return texture_; }
  cv::Mat Read() const;  // CV_32FC4, B G R A
  void Release();

 private:
  unsigned format_;
  int width_ = 0, height_ = 0;
  unsigned texture_ = 0, framebuffer_ = 0;
};

}  // namespace ulf::render
