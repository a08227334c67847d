#include "core/image/files/raw_file.h"

#include <libraw/libraw.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <system_error>
#include <utility>

#include "core/base/atomic_file.h"
#include "core/base/binary_file.h"
#include "core/base/error.h"
#include "core/image/clipped.h"
#include "core/image/files/dng_layout.h"
#include "core/image/files/image_header.h"
#include "core/image/image.h"

namespace ulf {
namespace {

// A camera crops some pixels of its sensor's. More than this share of a side is another picture: a smaller
// one, or one in another format. Guessed; 3 % occur.
constexpr double kMostCut = 0.05;

std::string SizeText(cv::Size size) { return fmt::format("{}x{}", size.width, size.height); }

// One LibRaw object is some hundred kilobytes large, frees what it has on destruction, and belongs to one
// thread.
class RawDecoder {
 public:
  explicit RawDecoder(std::string name) : name_(std::move(name)), raw_(std::make_unique<LibRaw>(0)) {
    // The type of the offset differs between versions of the library.
    raw_->set_dataerror_handler([](void* count, const char*, auto) { ++*static_cast<int*>(count); },
                                &data_errors_);
    libraw_output_params_t& params = raw_->imgdata.params;
    params.output_bps = 16;
    params.gamm[0] = params.gamm[1] = 1;
    params.no_auto_bright = 1;
    params.adjust_maximum_thr = 0;  // full scale does not depend on the picture
    params.use_camera_wb = 1;
    params.output_color = 1;  // the primaries of sRGB
    params.highlight = 0;     // clipped
    params.user_flip = 0;     // in the sensor's orientation
  }

  void OpenFile() {
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(name_, unknown))
      throw Error("{}: the raw file is missing or cannot be read; restore it", name_);
    file_bytes_ = std::filesystem::file_size(name_);
    std::ifstream file(name_, std::ios::binary);
    const bool has_tiles =
        CheckLayout([&](std::uint64_t at, std::size_t count) { return BytesAt(file, at, count); });
    if (has_tiles)
      OpenTiles(ReadWholeFile(name_));
    else
      Open([this](LibRaw& raw) { return raw.open_file(name_.c_str()); });
  }
  void OpenBytes(const std::string& bytes) {
    file_bytes_ = bytes.size();
    const bool has_tiles = CheckLayout([&](std::uint64_t at, std::size_t count) {
      return at < bytes.size() ? bytes.substr(at, count) : std::string();
    });
    if (has_tiles)
      OpenTiles(bytes);
    else
      Open([&](LibRaw& raw) { return raw.open_buffer(const_cast<char*>(bytes.data()), bytes.size()); });
  }

  RawFacts Facts() const;
  cv::Mat Light(RawQuality quality, std::optional<cv::Size> wanted,
                const std::optional<WhiteBalance>& white_balance);
  // Call it after Light(), for the same crop.
  cv::Mat Clipped(std::optional<cv::Size> wanted) const;

 private:
  // Refuses mosaics that LibRaw takes for others. Returns whether the pixels are in tiles that it misreads.
  bool CheckLayout(const ReadBytesAt& read);
  void OpenTiles(const std::string& bytes) {
    without_tiles_ = DngWithoutTiles(bytes, name_);
    Open([this](LibRaw& raw) { return raw.open_buffer(without_tiles_.data(), without_tiles_.size()); });
  }
  // Subtracts the black level of a picture whose pixels have all colours: LibRaw subtracts it and scales as
  // if it were 0.
  void SubtractBlackOfLinear();
  void Open(const std::function<int(LibRaw&)>& open);
  void Require(int result) const;
  void CheckKind() const;
  void Develop(RawQuality quality, const std::optional<WhiteBalance>& white_balance);
  // Returns pixels of the visible area.
  cv::Rect CropTo(std::optional<cv::Size> wanted) const;

  const std::string name_;
  const std::unique_ptr<LibRaw> raw_;
  std::string without_tiles_;  // read by LibRaw
  std::vector<double> linear_black_;
  cv::Size linear_black_period_;
  std::uint64_t file_bytes_ = 0;
  int data_errors_ = 0;
  cv::Rect crop_of_camera_;  // px of the visible area; empty if not in the file
};

[[noreturn]] void RefuseDamaged(const std::string& name, const std::string& words) {
  throw Error("{}: the raw file is cut short or damaged ({}); copy it again from the card", name, words);
}

void RawDecoder::Require(int result) const {
  const std::string words = result > 0 ? std::generic_category().message(result) : LibRaw::strerror(result);
  switch (result) {
    case LIBRAW_SUCCESS:
      return;
    case LIBRAW_UNSUFFICIENT_MEMORY:
    case LIBRAW_TOO_BIG:
      throw Error("{}: decoding takes more memory than there is ({}); convert it to 16-bit TIFF elsewhere",
                  name_, words);
    default:
      RefuseDamaged(name_, words);
  }
}

void RawDecoder::CheckKind() const {
  const libraw_image_sizes_t& sizes = raw_->imgdata.sizes;
  if (sizes.width == 0 || sizes.height == 0) RefuseDamaged(name_, "it has no pixels");
  constexpr double kBytesOfPixel = 8;  // LibRaw's: four colours of 16 bits
  RequirePixelsOfFile(name_, file_bytes_, 1.0 * sizes.raw_width * sizes.raw_height, kBytesOfPixel);
  if (raw_->is_fuji_rotated() || std::abs(sizes.pixel_aspect - 1) > 1e-3)
    throw Error(
        "{}: the pixels of this sensor ({} {}) are not square, and its pictures are resampled; use the "
        "camera's JPEG",
        name_, raw_->imgdata.idata.make, raw_->imgdata.idata.model);
}

bool RawDecoder::CheckLayout(const ReadBytesAt& read) {
  const auto layout = DngLayoutOf(read);
  if (!layout) return false;
  if (!IsKnownMosaic(*layout))
    throw Error(
        "{}: its sensor has a {} mosaic{}, which is not read (Bayer's of 2x2 and X-Trans are); develop it "
        "elsewhere and take 16-bit TIFF, or let the camera combine its pixels",
        name_, layout->is_staggered ? "staggered" : SizeText(layout->mosaic),
        layout->pattern.size() <= 4 && !layout->is_staggered ? " (" + layout->pattern + ")" : "");
  linear_black_ = layout->black;
  linear_black_period_ = layout->black_period;
  return layout->has_plain_tiles;
}

void RawDecoder::SubtractBlackOfLinear() {
  libraw_rawdata_t& data = raw_->imgdata.rawdata;
  libraw_colordata_t& color = data.color;
  std::uint16_t* const pixels = data.color4_image   ? data.color4_image[0]
                                : data.color3_image ? data.color3_image[0]
                                                    : nullptr;
  if (raw_->imgdata.idata.filters != 0 || !pixels) return;
  const std::size_t samples = data.color4_image ? 4 : 3;
  const libraw_image_sizes_t& sizes = data.sizes;
  // Repeats as the file says; LibRaw ignores the period.
  const auto columns = static_cast<std::size_t>(linear_black_period_.width),
             rows = static_cast<std::size_t>(linear_black_period_.height);
  const std::size_t colors = columns * rows > 0 ? linear_black_.size() / (columns * rows) : 0;
  const auto black_at = [&](std::size_t y, std::size_t x, std::size_t c) {
    if (colors == 0) return static_cast<double>(color.black + color.cblack[c]);
    return linear_black_[(y % rows * columns + x % columns) * colors + std::min(c, colors - 1)];
  };
  const double white = color.maximum;
  const auto top = static_cast<std::size_t>(sizes.top_margin),
             left = static_cast<std::size_t>(sizes.left_margin);
  for (std::size_t y = 0; y < sizes.raw_height; ++y)
    for (std::size_t x = 0; x < sizes.raw_width; ++x)
      for (std::size_t c = 0; c < 3; ++c) {
        // The pattern begins at the visible area's corner.
        const double black = black_at(y + rows * top - top, x + columns * left - left, c);
        if (black <= 0 || black >= white) continue;
        std::uint16_t& sample = pixels[(y * sizes.raw_width + x) * samples + c];
        sample = cv::saturate_cast<std::uint16_t>((sample - black) * white / (white - black));
      }
  color.black = 0;
  std::ranges::fill(color.cblack, 0);
}

// Returns the crop of makers' notes, in pixels of the visible area.
cv::Rect InsetCrop(const libraw_image_sizes_t& sizes) {
#if LIBRAW_COMPILE_CHECK_VERSION_NOTLESS(0, 21)
  const libraw_raw_inset_crop_t& inset = sizes.raw_inset_crops[0];  // a DNG's default crop, too
#else
  const libraw_raw_inset_crop_t& inset = sizes.raw_inset_crop;
#endif
  constexpr unsigned kUnknown = 0xffff;
  if (inset.cwidth == 0 || inset.cheight == 0 || inset.cleft == kUnknown || inset.ctop == kUnknown) return {};
  return {inset.cleft - sizes.left_margin, inset.ctop - sizes.top_margin, inset.cwidth, inset.cheight};
}

void RawDecoder::Open(const std::function<int(LibRaw&)>& open) {
  const int result = open(*raw_);
  if (result == LIBRAW_UNSUFFICIENT_MEMORY || result == LIBRAW_TOO_BIG) Require(result);
  if (result != LIBRAW_SUCCESS)
    throw Error(
        "{}: is no raw file of a kind that LibRaw {} reads, or is cut short or damaged at its beginning; "
        "copy it again from the card, or convert it to DNG or to 16-bit TIFF",
        name_, LibRaw::version());
  CheckKind();
  const libraw_image_sizes_t& sizes = raw_->imgdata.sizes;
  cv::Rect crop = InsetCrop(sizes);
#if !LIBRAW_COMPILE_CHECK_VERSION_NOTLESS(0, 21)
  if (raw_->imgdata.idata.dng_version) {
    // LibRaw 0.20 applies a DNG's default crop only when the file is opened with that option.
    const auto cropped = std::make_unique<LibRaw>(0);
    cropped->imgdata.params.raw_processing_options |= LIBRAW_PROCESSING_USE_DNG_DEFAULT_CROP;
    const libraw_image_sizes_t& to = cropped->imgdata.sizes;
    if (open(*cropped) == LIBRAW_SUCCESS)
      crop = {to.left_margin - sizes.left_margin, to.top_margin - sizes.top_margin, to.width, to.height};
  }
#endif
  const cv::Rect visible(0, 0, sizes.width, sizes.height);
  if (crop.area() > 0 && (crop & visible) == crop) crop_of_camera_ = crop;
}

RawFacts RawDecoder::Facts() const {
  const libraw_data_t& data = raw_->imgdata;
  RawFacts facts;
  facts.visible = {data.sizes.width, data.sizes.height};
  facts.size = crop_of_camera_.empty() ? facts.visible : crop_of_camera_.size();
  const auto positive = [](double number) {
    return number > 0 && std::isfinite(number) ? std::optional(number) : std::nullopt;
  };
  facts.exif.exposure_s = positive(data.other.shutter);
  facts.exif.f_number = positive(data.other.aperture);
  facts.exif.iso = positive(data.other.iso_speed);
  facts.exif.focal_mm = positive(data.other.focal_len);
  facts.exif.focal_35mm = positive(data.lens.FocalLengthIn35mmFormat);
  facts.exif.orientation = data.sizes.flip == 3 ? 3 : data.sizes.flip == 5 ? 8 : data.sizes.flip == 6 ? 6 : 1;
  if (data.other.timestamp > 0)
    facts.exif.taken = fmt::format("{:020}", static_cast<std::int64_t>(data.other.timestamp));
  facts.exif.lens = ExifText(data.lens.Lens);
  if (facts.exif.lens.empty()) facts.exif.lens = ExifText(data.lens.makernotes.Lens);
  facts.maker = data.idata.make;
  facts.model = data.idata.model;
  const float* as_shot = data.color.cam_mul;
  facts.has_white_balance = as_shot[0] > 0 && as_shot[1] > 0 && as_shot[2] > 0;
  const float* factors = facts.has_white_balance ? as_shot : data.color.pre_mul;
  const double green = factors[1] > 0 ? factors[1] : 1;
  facts.white_balance = {factors[0] / green, 1, factors[2] / green};
  facts.has_color_matrix =
      data.idata.colors == 1 || data.color.cam_xyz[0][0] != 0 || data.color.cmatrix[0][0] != 0;
  return facts;
}

bool IsCutOf(cv::Size wanted, cv::Size whole) {
  const auto fits = [](int part, int all) { return part > 0 && part <= all && part >= (1 - kMostCut) * all; };
  return fits(wanted.width, whole.width) && fits(wanted.height, whole.height);
}

cv::Rect RawDecoder::CropTo(std::optional<cv::Size> wanted) const {
  const RawFacts facts = Facts();
  const cv::Rect visible({}, facts.visible);
  const cv::Rect usual = crop_of_camera_.empty() ? visible : crop_of_camera_;
  if (!wanted || *wanted == usual.size()) return usual;
  if (!CanCropRaw(facts, *wanted))
    throw Error("{}: the raw picture is {} (of {} that the sensor shows), its camera says {}; {}", name_,
                SizeText(usual.size()), SizeText(visible.size()), SizeText(*wanted),
                wanted->width == usual.height && wanted->height == usual.width
                    ? "the other program turned it by its Exif mark, and ulf does not: pose photographs that "
                      "were not turned"
                    : "raw files have the sensor's full size: take the JPEG files of the size that was "
                      "calibrated, or calibrate at the camera's largest size");
  const cv::Rect& whole = IsCutOf(*wanted, usual.size()) ? usual : visible;
  return {whole.x + (whole.width - wanted->width) / 2, whole.y + (whole.height - wanted->height) / 2,
          wanted->width, wanted->height};
}

void RawDecoder::Develop(RawQuality quality, const std::optional<WhiteBalance>& white_balance) {
  // LibRaw uses the colours from when the pixels were unpacked. Its own parameter for factors would ignore
  // the colour matrices of some files, and the white patch that a few old cameras measured has precedence
  // over the tag.
  if (white_balance) {
    libraw_colordata_t& color = raw_->imgdata.rawdata.color;
    std::ranges::copy(*white_balance, color.cam_mul);
    color.cam_mul[3] = 0;  // the second green equals the first
    for (auto& row : color.white) std::ranges::fill(row, 0);
  }
  // Markesteijn's method works in tiles, and LibRaw reports smaller pictures as damaged.
  constexpr int kTile = 512;
  const libraw_data_t& data = raw_->imgdata;
  const bool is_small_xtrans =
      data.idata.filters == LIBRAW_XTRANS && std::min(data.sizes.width, data.sizes.height) < kTile;
  constexpr int kBilinear = 0, kAhd = 3;
  raw_->imgdata.params.user_qual = quality == RawQuality::kQuick || is_small_xtrans ? kBilinear : kAhd;
  Require(raw_->dcraw_process());
}

cv::Mat RawDecoder::Light(RawQuality quality, std::optional<cv::Size> wanted,
                          const std::optional<WhiteBalance>& white_balance) {
  const cv::Rect crop = CropTo(wanted);
  Require(raw_->unpack());
  if (data_errors_ > 0) RefuseDamaged(name_, "its pixels end too early or make no sense");
  SubtractBlackOfLinear();
  Develop(quality, white_balance);
  const libraw_data_t& data = raw_->imgdata;
  if (!data.image || data.sizes.iwidth < crop.br().x || data.sizes.iheight < crop.br().y)
    RefuseDamaged(name_, "it decodes to another size than it says");
  const bool is_grey = data.idata.colors == 1;
  cv::Mat light(crop.size(), CV_16UC3);
  for (int y = 0; y < crop.height; ++y) {
    const auto* in = data.image + static_cast<std::size_t>(crop.y + y) * data.sizes.iwidth + crop.x;
    auto* out = light.ptr<cv::Vec3w>(y);
    for (int x = 0; x < crop.width; ++x)
      out[x] = is_grey ? cv::Vec3w::all(in[x][0]) : cv::Vec3w(in[x][2], in[x][1], in[x][0]);
  }
  return light;
}

cv::Mat RawDecoder::Clipped(std::optional<cv::Size> wanted) const {
  const cv::Rect crop = CropTo(wanted);
  const libraw_data_t& data = raw_->imgdata;
  cv::Mat clipped = cv::Mat::zeros(crop.size(), CV_8UC1);
  const std::uint16_t* mosaic = data.rawdata.raw_image;
  if (!mosaic ||
      data.idata.filters == 0) {  // every pixel has all colours: clipping shows in the light itself
    for (int y = 0; y < crop.height; ++y)
      for (int x = 0; x < crop.width; ++x) {
        const auto* in = data.image[static_cast<std::size_t>(crop.y + y) * data.sizes.iwidth + crop.x + x];
        const int most = data.idata.colors == 1 ? in[0] : std::max({in[0], in[1], in[2]});
        clipped.at<std::uint8_t>(y, x) = most >= kClippedFrom * FullScale(CV_16U) ? 255 : 0;
      }
    return cv::countNonZero(clipped) > 0 ? clipped : cv::Mat();
  }
  // LibRaw keeps the factors that it applied, the least of them 1, and full scale above black.
  const libraw_colordata_t& used = data.color;
  const libraw_colordata_t& recorded = data.rawdata.color;
  const auto black_at = [&](int row, int column, int color) {
    const unsigned rows = recorded.cblack[4], columns = recorded.cblack[5];
    unsigned black = recorded.black + recorded.cblack[color];
    if (rows > 0 && columns > 0)
      black += recorded.cblack[6 + static_cast<unsigned>(row) % rows * columns +
                               static_cast<unsigned>(column) % columns];
    return static_cast<double>(black);
  };
  const std::size_t pitch = data.sizes.raw_pitch / sizeof(std::uint16_t);
  for (int y = 0; y < crop.height; ++y)
    for (int x = 0; x < crop.width; ++x) {
      const int row = crop.y + y, column = crop.x + x, color = raw_->COLOR(row, column);
      const double number = mosaic[static_cast<std::size_t>(row + data.sizes.top_margin) * pitch +
                                   static_cast<std::size_t>(column + data.sizes.left_margin)];
      const double factor = color == 3 && !(used.pre_mul[3] > 0) ? used.pre_mul[1] : used.pre_mul[color];
      if ((number - black_at(row, column, color)) * factor >= kClippedFrom * used.maximum)
        clipped.at<std::uint8_t>(y, x) = 255;
    }
  return ClippedAfterDemosaicing(clipped);
}

}  // namespace

bool CanCropRaw(const RawFacts& facts, cv::Size wanted) {
  return IsCutOf(wanted, facts.size) || IsCutOf(wanted, facts.visible);
}

std::optional<WhiteBalance> LockedWhiteBalance::WhiteBalanceFor(const RawFacts& facts) {
  const MutexLock lock(mutex_);
  const WhiteBalance& first =
      first_.try_emplace({facts.maker, facts.model}, facts.white_balance).first->second;
  constexpr double kSame = 0.01;  // cameras round their factors
  for (std::size_t c = 0; c < first.size(); ++c)
    if (std::abs(facts.white_balance[c] - first[c]) > kSame * first[c]) return first;
  return std::nullopt;
}

RawFacts ReadRawFacts(const std::string& path) {
  RawDecoder decoder(path);
  decoder.OpenFile();
  return decoder.Facts();
}

cv::Mat ReadRawFile(const std::string& path, std::optional<cv::Size> wanted,
                    const std::optional<WhiteBalance>& white_balance, cv::Mat* clipped) {
  RawDecoder decoder(path);
  decoder.OpenFile();
  cv::Mat light = decoder.Light(RawQuality::kBest, wanted, white_balance);
  if (clipped) *clipped = decoder.Clipped(wanted);
  return light;
}

RawFacts RawFactsOf(const std::string& bytes, const std::string& name) {
  RawDecoder decoder(name);
  decoder.OpenBytes(bytes);
  return decoder.Facts();
}

RawPhotograph DecodeRaw(const std::string& bytes, const std::string& name, RawQuality quality,
                        std::optional<cv::Size> wanted, const std::optional<WhiteBalance>& white_balance,
                        cv::Mat* clipped) {
  RawDecoder decoder(name);
  decoder.OpenBytes(bytes);
  RawPhotograph photograph{.light = {}, .facts = decoder.Facts()};
  photograph.light = decoder.Light(quality, wanted, white_balance);
  if (clipped) *clipped = decoder.Clipped(wanted);
  return photograph;
}

}  // namespace ulf
