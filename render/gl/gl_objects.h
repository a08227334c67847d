// Thin wrappers of the OpenGL objects that the renderer uses. Their context must be current whenever they are
// used, and for Release(), which their owner must call: destructors release nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <string>
#include <type_traits>
#include <vector>

namespace ulf::render {

// Returns the largest number of layers of a texture array: the driver's limit, but at most 4095, of which two
// fit into one float (fan_batch.vert).
int MostLayers();

// Returns the remedy for full graphics memory, for a program that holds photographs there.
std::string FewerPhotographs();

// Throws Error if OpenGL reports an error; its text has `doing`, what was being done, and, if memory is
// exhausted, the remedy that `way_out` returns.
void CheckGl(const char* doing, std::string (*way_out)() = FewerPhotographs);
// Does the same after an allocation: `release` frees an object whose allocation failed, so that it is not
// used later as if it were valid.
void CheckMade(const char* doing, const std::function<void()>& release);

// Samples a texture with `filter` (GL_NEAREST or GL_LINEAR) and clamps coordinates to its edges.
void SetSampling(unsigned texture, unsigned filter);

// Enables the depth test with `function` (GL_EQUAL ...); if it `writes`, passing pixels write their depth.
void SetDepthTest(unsigned function, bool writes);

class GlProgram {
 public:
  // Both throw Error, which has the driver's reason, if the shaders do not compile; `name` is for its text.
  void Build(const std::string& name, const std::string& vertex_source, const std::string& fragment_source);
  void BuildCompute(const std::string& name, const std::string& source);
  void Use() const;
  // These ignore names that the compiler dropped.
  void Set(const char* name, int value) const;
  void Set(const char* name, float value) const;
  void Set(const char* name, const std::array<float, 4>& value) const;
  void Release();

 private:
  void Link(const std::string& name, std::initializer_list<unsigned> shaders);
  unsigned program_ = 0;
};

class GlBuffer {
 public:
  template <typename T>
  void Upload(const std::vector<T>& values) {
    UploadBytes(values.data(), values.size() * sizeof(T));
  }
  void Reserve(std::size_t bytes);  // for shaders to write; the contents are undefined
  void BindStorage(unsigned binding) const;
  unsigned name() const { return buffer_; }
  // Returns what shaders wrote into the buffer; waits for them.
  std::vector<std::int32_t> Read(std::size_t count) const;
  void ReadBytes(void* bytes, std::size_t count) const;
  void Release();

 private:
  void UploadBytes(const void* data, std::size_t size);
  unsigned buffer_ = 0;
};

// A buffer of integers, or of structs of vectors of four floats, that shaders read as texels.
class GlTexelBuffer {
 public:
  // Throws Error for more than the driver can address.
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

// A vertex array without attributes: the shader computes every vertex.
class GlEmptyVertexArray {
 public:
  void Bind();
  void Release();

 private:
  unsigned array_ = 0;
};

// Counts the pixels that pass the depth test between Begin() and End().
class GlPixelCounter {
 public:
  void Begin();
  void End() const;
  std::uint64_t Count() const;  // waits for the drawing
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

// An image to draw into, with a depth buffer if Resize() gets one. A Resize() to the present size changes
// nothing, and ignores another depth buffer.
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
