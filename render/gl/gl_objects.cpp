#include "render/gl/gl_objects.h"

#include <epoxy/gl.h>
#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"

namespace ulf::render {
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
    throw Error("OpenGL: shader {} does not compile on this driver: {}; use ulf render --renderer reference",
                name, log);
  }
  return shader;
}

}  // namespace

int MostLayers() {
  constexpr int kMostInShaders = 4095;  // fan_batch.vert adds 4096 times one layer to another
  GLint layers = 256;                   // the minimum of OpenGL 4.5
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &layers);
  return std::min(layers, kMostInShaders);
}

std::string FewerPhotographs() {
  return fmt::format("limit the photographs with {}", Parameter("gpu_memory"));
}

void CheckGl(const char* doing, std::string (*way_out)()) {
  const GLenum error = glGetError();
  if (error == GL_NO_ERROR) return;
  while (glGetError() != GL_NO_ERROR) {
  }
  if (error == GL_OUT_OF_MEMORY) throw Error("OpenGL: out of memory while {}; {}", doing, way_out());
  throw Error("OpenGL: error {:#x} while {}", error, doing);
}

void CheckMade(const char* doing, const std::function<void()>& release) {
  try {
    CheckGl(doing);
  } catch (const Error&) {
    release();
    throw;
  }
}

void SetSampling(unsigned texture, unsigned filter) {
  for (const GLenum which : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
    glTextureParameteri(texture, which, static_cast<GLint>(filter));
  for (const GLenum which : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
    glTextureParameteri(texture, which, GL_CLAMP_TO_EDGE);
}

void SetDepthTest(unsigned function, bool writes) {
  glEnable(GL_DEPTH_TEST);
  glDepthMask(writes ? GL_TRUE : GL_FALSE);
  glDepthFunc(function);
}

void GlProgram::Build(const std::string& name, const std::string& vertex_source,
                      const std::string& fragment_source) {
  const unsigned vertex = CompileShader(GL_VERTEX_SHADER, name + " (vertices)", vertex_source);
  const unsigned fragment = CompileShader(GL_FRAGMENT_SHADER, name + " (fragments)", fragment_source);
  Link(name, {vertex, fragment});
  // Drivers interpret a binding on an array of samplers differently: set unit n for sampler n.
  for (int n = 0; n < 16; ++n) {
    const int location = glGetUniformLocation(program_, ("photographs[" + std::to_string(n) + "]").c_str());
    if (location >= 0) glProgramUniform1i(program_, location, n);
  }
}

void GlProgram::BuildCompute(const std::string& name, const std::string& source) {
  Link(name, {CompileShader(GL_COMPUTE_SHADER, name, source)});
}

void GlProgram::Link(const std::string& name, std::initializer_list<unsigned> shaders) {
  program_ = glCreateProgram();
  for (const unsigned shader : shaders) glAttachShader(program_, shader);
  glLinkProgram(program_);
  for (const unsigned shader : shaders) glDeleteShader(shader);
  GLint ok = 0;
  glGetProgramiv(program_, GL_LINK_STATUS, &ok);
  if (!ok)
    throw Error("OpenGL: shader {} does not link on this driver; use ulf render --renderer reference", name);
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
  constexpr std::size_t kLeast = 16;  // bytes: an empty buffer cannot be bound
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(std::max(size, kLeast)), nullptr, GL_STREAM_DRAW);
  if (size > 0) glNamedBufferSubData(buffer_, 0, static_cast<GLsizeiptr>(size), data);
}

void GlBuffer::Reserve(std::size_t bytes) {
  if (!buffer_) glCreateBuffers(1, &buffer_);
  glNamedBufferData(buffer_, static_cast<GLsizeiptr>(bytes), nullptr, GL_STREAM_READ);
}

void GlBuffer::BindStorage(unsigned binding) const {
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, buffer_);
}

std::vector<std::int32_t> GlBuffer::Read(std::size_t count) const {
  std::vector<std::int32_t> values(count);
  ReadBytes(values.data(), count * sizeof(std::int32_t));
  return values;
}

void GlBuffer::ReadBytes(void* bytes, std::size_t count) const {
  glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
  glGetNamedBufferSubData(buffer_, 0, static_cast<GLsizeiptr>(count), bytes);
}

void GlBuffer::Release() {
  if (buffer_) glDeleteBuffers(1, &buffer_);
  buffer_ = 0;
}

void GlPixelCounter::Begin() {
  if (!query_) glCreateQueries(GL_SAMPLES_PASSED, 1, &query_);
  glBeginQuery(GL_SAMPLES_PASSED, query_);
}

void GlPixelCounter::End() const { glEndQuery(GL_SAMPLES_PASSED); }

std::uint64_t GlPixelCounter::Count() const {
  GLuint64 count = 0;
  glGetQueryObjectui64v(query_, GL_QUERY_RESULT, &count);
  return count;
}

void GlPixelCounter::Release() {
  if (query_) glDeleteQueries(1, &query_);
  query_ = 0;
}

void GlTexelBuffer::Attach(std::size_t bytes, bool integers) {
  const std::size_t texels = bytes / (integers ? sizeof(std::int32_t) : 4 * sizeof(float));
  GLint most = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &most);
  if (texels > static_cast<std::size_t>(most))
    throw Error(
        "OpenGL: this driver cannot address {} texels, only {}, too few for the number of views; use {} "
        "reference",
        texels, most, Parameter("renderer"));
  if (!texture_) glCreateTextures(GL_TEXTURE_BUFFER, 1, &texture_);
  glTextureBuffer(texture_, integers ? GL_R32I : GL_RGBA32F, buffer_.name());
}

void GlTexelBuffer::Bind(unsigned unit) const { glBindTextureUnit(unit, texture_); }

void GlTexelBuffer::Release() {
  if (texture_) glDeleteTextures(1, &texture_);
  texture_ = 0;
  buffer_.Release();
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
  CheckMade("making the depths to draw into", [&] { Release(); });
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
  SetSampling(texture_, GL_NEAREST);
  glCreateFramebuffers(1, &framebuffer_);
  glNamedFramebufferTexture(framebuffer_, GL_COLOR_ATTACHMENT0, texture_, 0);
  if (depth)
    glNamedFramebufferRenderbuffer(framebuffer_, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth->name());
  CheckMade("making the image to draw into", [&] { Release(); });
  if (glCheckNamedFramebufferStatus(framebuffer_, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    Release();
    throw Error(
        "OpenGL: this driver cannot draw into a float image of {}x{}; render smaller, or with {} reference",
        width, height, Parameter("renderer"));
  }
}

void GlTarget::Bind() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  glViewport(0, 0, width_, height_);
}

void GlTarget::Clear(float value) const { Clear({value, value, value, value}); }

void GlTarget::Clear(const std::array<float, 4>& rgba) const {
  glClearNamedFramebufferfv(framebuffer_, GL_COLOR, 0, rgba.data());
}

void GlTarget::ClearDepth(float value) const {
  glDepthMask(GL_TRUE);
  glClearNamedFramebufferfv(framebuffer_, GL_DEPTH, 0, &value);
}

void GlTarget::BindTexture(unsigned unit) const { glBindTextureUnit(unit, texture_); }

void GlTarget::CopyTo(const GlTarget& other) const {
  glCopyImageSubData(texture_, GL_TEXTURE_2D, 0, 0, 0, 0, other.texture_, GL_TEXTURE_2D, 0, 0, 0, 0, width_,
                     height_, 1);
}

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

}  // namespace ulf::render
