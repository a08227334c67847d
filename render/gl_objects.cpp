#include "render/gl_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <map>

#include "acquisition/error.h"

namespace ulf {
namespace {

unsigned CompileShader(unsigned type, const std::string& name, const std::string& source) {
  const unsigned shader = glCreateShader(type);
  const char* text = source.c_str();
  glShaderSource(shader, 1, &text, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (!ok) {
    std::string log(4096, '\0');
    GLsizei length = 0;
    glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
    log.resize(static_cast<std::size_t>(length));
    throw Error("OpenGL: shader {} does not compile on this driver: {}; render with --renderer reference",
                name, log);
  }
  return shader;
}

}  // namespace

void CheckGl(const char* doing) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  if (error == GL_OUT_OF_MEMORY)
    throw Error("OpenGL: out of memory while {}; load smaller photographs (--size-limit)", doing);
  throw Error("OpenGL: error {:#x} while {}", error, doing);
}

void GlProgram::Build(const std::string& name, const std::string& vertex_source,
                      const std::string& fragment_source) {
  const unsigned vertex = CompileShader(GL_VERTEX_SHADER, name + " (vertices)", vertex_source);
  const unsigned fragment = CompileShader(GL_FRAGMENT_SHADER, name + " (fragments)", fragment_source);
  program_ = glCreateProgram();
  glAttachShader(program_, vertex);
  glAttachShader(program_, fragment);
  glLinkProgram(program_);
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  GLint ok = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &ok);
  if (!ok)
    throw Error("OpenGL: shader {} does not link on this driver; render with --renderer reference", name);
  // Texture units follow the array's index whatever the driver makes of a binding on an array of samplers.
  for (int n = 0; n < 16; ++n) {
    const int location = glGetUniformLocation(program_, ("photographs[" + std::to_string(n) + "]").c_str());
    if (location >= 0) glProgramUniform1i(program_, location, n);
  }
}

void GlProgram::Use() const { glUseProgram(program_); }

void GlProgram::Set(const char* name, int value) const {
  glProgramUniform1i(program_, glGetUniformLocation(program_, name), value);
}
void GlProgram::Set(const char* name, float value) const {
  glProgramUniform1f(program_, glGetUniformLocation(program_, name), value);
}
void GlProgram::Set(const char* name, const std::array<float, 4>& value) const {
  glProgramUniform4fv(program_, glGetUniformLocation(program_, name), 1, value.data());
}

void GlProgram::Release() {
  if (program_) glDeleteProgram(program_);
  program_ = 0;
}

void GlBuffer::UploadBytes(const void* data, std::size_t size) {
  if (!buffer_) glCreateBuffers(1, &buffer_);
  constexpr std::size_t kLeast = 16;  // an empty buffer cannot be bound
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(std::max(size, kLeast)), nullptr, GL_STREAM_DRAW);
  if (size > 0) glNamedBufferSubData(buffer_, 0, static_cast<GLsizeiptr>(size), data);
}

void GlBuffer::BindStorage(unsigned binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_);
}

void GlBuffer::Release() {
  if (buffer_) glDeleteBuffers(1, &buffer_);
  buffer_ = 0;
}

void GlEmptyVertexArray::Bind() {
  if (!array_) glCreateVertexArrays(1, &array_);
  glBindVertexArray(array_);
}

void GlEmptyVertexArray::Release() {
  if (array_) glDeleteVertexArrays(1, &array_);
  array_ = 0;
}

void GlDepth::Resize(int width, int height) {
  if (width == width_ && height == height_) return;
  Release();
  width_ = width;
  height_ = height;
  glCreateRenderbuffers(1, &buffer_);
  glNamedRenderbufferStorage(buffer_, GL_DEPTH_COMPONENT32F, width, height);
}

void GlDepth::Release() {
  if (buffer_) glDeleteRenderbuffers(1, &buffer_);
  buffer_ = 0;
  width_ = height_ = 0;
}

void GlTarget::Resize(int width, int height, const GlDepth* depth) {
  if (width == width_ && height == height_) return;
  Release();
  width_ = width;
  height_ = height;
  glCreateTextures(GL_TEXTURE_2D, 1, &texture_);
  glTextureStorage2D(texture_, 1, format_, width, height);
  glTextureParameteri(texture_, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  glTextureParameteri(texture_, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  glCreateFramebuffers(1, &framebuffer_);
  glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, texture_, 0);
  if (depth)
    glNamedFramebufferRenderbuffer(framebuffer_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth->name());
  CheckGl("making the image to draw into");
  if (glCheckNamedFramebufferStatus(framebuffer_, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw Error(
        "OpenGL: this driver cannot draw into a float image of {}x{}; render smaller, or with --renderer "
        "reference",
        width, height);
}

void GlTarget::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
}

void GlTarget::Clear(float value) const {
  const std::array<float, 4> values{value, value, value, value};
  glClearNamedFramebufferfv(framebuffer_, GL_COLOR, 0, values.data());
}

void GlTarget::ClearDepth(float value) const {
  glDepthMask(GL_TRUE);
  glClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &value);
}

void GlTarget::BindTexture(unsigned unit) const { glBindTextureUnit(unit, texture_); }

cv::Mat GlTarget::Read() const {
  cv::Mat pixels(height_, width_, CV_32FC4);
  glPixelStorei(GL_PACK_ALIGNMENT, 4);
  glGetTextureImage(texture_, 0, GL_BGRA, GL_FLOAT, static_cast<GLsizei>(pixels.total() * pixels.elemSize()),
                    pixels.data);
  CheckGl("reading the picture back");
  return pixels;
}

void GlTarget::Release() {
  if (framebuffer_) glDeleteFramebuffers(1, &framebuffer_);
  if (texture_) glDeleteTextures(1, &texture_);
  framebuffer_ = texture_ = 0;
  width_ = height_ = 0;
}

void PhotographTextures::Upload(const std::vector<const ViewPyramid*>& pyramids) {
  constexpr double kMostBytes = 1e9;  // an array of 1.26 GB has worked, one of 2.3 GB has not
  constexpr std::size_t kMostArrays = 12;
  GLint most_layers = 256;
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);

  const bool linear = !pyramids.empty() && pyramids.front()->front().depth() == CV_16F;
  const GLenum stored = linear ? GL_RGBA16F : GL_SRGB8_ALPHA8;
  const GLenum order = linear ? GL_BGRA : GL_BGR, type = linear ? GL_HALF_FLOAT : GL_UNSIGNED_BYTE;
  std::map<std::pair<int, int>, std::vector<std::size_t>> views_of_size;
  for (std::size_t i = 0; i < pyramids.size(); ++i)
    views_of_size[{pyramids[i]->front().cols, pyramids[i]->front().rows}].push_back(i);
  places_.resize(pyramids.size());
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (const auto& [size, members] : views_of_size) {
    const auto [width, height] = size;
    const double bytes_a_layer = (linear ? 8.0 : 4.0) * width * height * 4 / 3;
    const std::size_t most = std::clamp<std::size_t>(static_cast<std::size_t>(kMostBytes / bytes_a_layer), 1,
                                                     static_cast<std::size_t>(most_layers));
    const int levels = static_cast<int>(pyramids[members.front()]->size());
    for (std::size_t begin = 0; begin < members.size(); begin += most) {
      const std::size_t layers = std::min(most, members.size() - begin);
      unsigned array = 0;
      glCreateTextures(GL_TEXTURE_2D_ARRAY, 1, &array);
      arrays_.push_back(array);
      glTextureStorage3D(array, levels, stored, width, height, static_cast<GLsizei>(layers));
      CheckGl("making room for the photographs");
      glTextureParameteri(array, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
      glTextureParameteri(array, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
      glTextureParameteri(array, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
      glTextureParameteri(array, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
      for (std::size_t layer = 0; layer < layers; ++layer) {
        const std::size_t view = members[begin + layer];
        places_[view] = {static_cast<int>(arrays_.size()) - 1, static_cast<int>(layer)};
        for (int level = 0; level < levels; ++level) {
          const cv::Mat& pixels = (*pyramids[view])[static_cast<std::size_t>(level)];
          const cv::Mat packed = pixels.isContinuous() ? pixels : pixels.clone();
          glTextureSubImage3D(array, level, 0, 0, static_cast<GLint>(layer), packed.cols, packed.rows, 1,
                              order, type, packed.data);
        }
      }
      CheckGl("copying the photographs");
    }
  }
  if (arrays_.size() > kMostArrays)
    throw Error(
        "OpenGL: {} texture arrays are needed (photographs of many sizes, or too many), {} can be used; load "
        "smaller photographs (--size-limit) or render with --renderer reference",
        arrays_.size(), kMostArrays);
}

void PhotographTextures::Bind() const {
  for (std::size_t n = 0; n < arrays_.size(); ++n) glBindTextureUnit(static_cast<GLuint>(n), arrays_[n]);
}

void PhotographTextures::Release() {
  if (!arrays_.empty()) glDeleteTextures(static_cast<GLsizei>(arrays_.size()), arrays_.data());
  arrays_.clear();
}

}  // namespace ulf
