#include "acquisition/simulator/scene/materials.h"

#include <vector>

#include "acquisition/simulator/scene/noise.h"

namespace ulf::acquisition {
namespace {

using Eigen::Vector3f;

// Linear light, given in the order red, green, blue.
constexpr F4 Rgb(float r, float g, float b) { return F4{b, g, r, 0}; }

F4 Mix(F4 a, F4 b, float share) { return a + share * (b - a); }

// Returns 0 below the edge, 1 above it, a linear ramp of `width` between.
float SoftStep(float edge, float width, float x) {
  return std::clamp((x - edge) / std::max(width, 1e-6f) + 0.5f, 0.0f, 1.0f);
}

template <std::size_t N>
F4 Pick(const F4 (&palette)[N], std::uint32_t hash) {
  const F4 color = palette[hash % N];
  return color * (0.82f + 0.36f * UnitFloat(Rehash(hash)));
}

// `base` with chips of stone: `share` of the cells of that size contain one.
template <std::size_t N>
F4 WithChips(F4 base, float x, float y, float cell_m, float share, const F4 (&palette)[N], float texel_m,
             std::uint32_t seed) {
  const Cell cell = ScatteredCell2(x / cell_m, y / cell_m, seed);
  if (UnitFloat(Rehash(cell.hash ^ seed)) > share) return base;
  const float gap = 0.04f + 0.16f * UnitFloat(Rehash(cell.hash + 17));
  return Mix(base, Pick(palette, cell.hash), SoftStep(gap, texel_m / cell_m, cell.to_border));
}

template <std::size_t N>
F4 WithChips3(F4 base, const Vector3f& p, float cell_m, float share, const F4 (&palette)[N], float texel_m,
              std::uint32_t seed) {
  const Cell cell = ScatteredCell3(p / cell_m, seed);
  if (UnitFloat(Rehash(cell.hash ^ seed)) > share) return base;
  const float gap = 0.03f + 0.12f * UnitFloat(Rehash(cell.hash + 17));
  return Mix(base, Pick(palette, cell.hash), SoftStep(gap, texel_m / cell_m, cell.to_border));
}

F4 Terrazzo(const PaintedPoint& at) {
  static const F4 kStone[] = {Rgb(.05f, .06f, .07f), Rgb(.30f, .19f, .13f), Rgb(.16f, .19f, .18f),
                              Rgb(.48f, .43f, .36f), Rgb(.10f, .13f, .16f), Rgb(.36f, .31f, .26f)};
  static const F4 kGrit[] = {Rgb(.06f, .06f, .06f), Rgb(.52f, .48f, .42f), Rgb(.28f, .18f, .13f)};
  const float cloud = FractalNoise({9 * at.u_m, 9 * at.v_m, 0}, 3, 11);
  F4 color = Rgb(.21f, .20f, .19f) * (0.7f + 0.6f * cloud);
  color = WithChips(color, at.u_m, at.v_m, 0.009f, 0.45f, kGrit, at.texel_m, 12);
  color = WithChips(color, at.u_m, at.v_m, 0.021f, 0.5f, kStone, at.texel_m, 13);
  return WithChips(color, at.u_m, at.v_m, 0.046f, 0.36f, kStone, at.texel_m, 14);
}

F4 Fieldstone(const PaintedPoint& at) {
  static const F4 kStone[] = {Rgb(.30f, .26f, .21f), Rgb(.22f, .23f, .24f), Rgb(.38f, .30f, .22f),
                              Rgb(.17f, .15f, .14f), Rgb(.32f, .31f, .28f), Rgb(.27f, .19f, .14f)};
  static const F4 kFleck[] = {Rgb(.08f, .08f, .08f), Rgb(.52f, .48f, .40f), Rgb(.34f, .20f, .12f)};
  const float bend_u = FractalNoise({6 * at.u_m, 6 * at.v_m, 3}, 2, 21) - 0.5f;
  const float bend_v = FractalNoise({6 * at.u_m, 6 * at.v_m, 8}, 2, 22) - 0.5f;
  const float u = at.u_m + 0.06f * bend_u, v = at.v_m + 0.06f * bend_v;
  constexpr float kWidth = 0.19f, kHeight = 0.105f;  // of a stone
  const Cell stone = ScatteredCell2(u / kWidth, v / kHeight, 23);
  const Vector3f own_offset(static_cast<float>(stone.hash % 97), static_cast<float>(stone.hash % 89), 0);
  const float grain = FractalNoise(Vector3f(34 * u, 34 * v, 0) + own_offset, 4, 24);
  F4 color = Pick(kStone, stone.hash) * (0.55f + 0.95f * grain);
  color = WithChips(color, u, v, 0.017f, 0.22f, kFleck, at.texel_m, 25);
  color = WithChips(color, u, v, 0.04f, 0.16f, kFleck, at.texel_m, 26);
  const float mortar_grain = FractalNoise({60 * at.u_m, 60 * at.v_m, 5}, 2, 27);
  const F4 mortar = Rgb(.44f, .42f, .38f) * (0.7f + 0.5f * mortar_grain);
  return Mix(mortar, color, SoftStep(0.06f, 0.03f, stone.to_border));
}

F4 Plaster(const PaintedPoint& at) {
  static const F4 kPatch[] = {Rgb(.34f, .33f, .31f), Rgb(.46f, .44f, .40f), Rgb(.26f, .27f, .29f),
                              Rgb(.40f, .34f, .28f)};
  const std::uint32_t seed = 30 + static_cast<std::uint32_t>(at.chart);
  const float cloud = FractalNoise({2 * at.u_m, 2 * at.v_m, 0}, 4, seed);
  F4 color = Rgb(.42f, .40f, .37f) * (0.7f + 0.6f * cloud);
  color = WithChips(color, at.u_m, at.v_m, 0.16f, 0.4f, kPatch, at.texel_m, seed + 50);
  return WithChips(color, at.u_m, at.v_m, 0.38f, 0.4f, kPatch, at.texel_m, seed + 60);
}

F4 TileMosaic(const PaintedPoint& at) {
  static const F4 kTile[] = {Rgb(.04f, .20f, .22f), Rgb(.62f, .57f, .44f), Rgb(.07f, .30f, .30f),
                             Rgb(.02f, .07f, .12f), Rgb(.46f, .24f, .08f)};
  const Cell tile = ScatteredCell3(at.local / 0.014f, 41);
  const F4 grout = Rgb(.33f, .32f, .30f);
  const float grain = 0.85f + 0.3f * ValueNoise(at.local * 260, 42);
  return Mix(grout, Pick(kTile, tile.hash) * grain, SoftStep(0.06f, at.texel_m / 0.014f, tile.to_border));
}

F4 Marbled(const PaintedPoint& at) {
  static const F4 kPaint[] = {Rgb(.68f, .56f, .32f), Rgb(.10f, .26f, .36f), Rgb(.55f, .18f, .10f),
                              Rgb(.74f, .70f, .60f), Rgb(.13f, .34f, .22f), Rgb(.80f, .46f, .10f)};
  static const F4 kSpot[] = {Rgb(.06f, .06f, .08f), Rgb(.82f, .80f, .74f)};
  const Vector3f bend(FractalNoise(at.local * 30, 3, 51), FractalNoise(at.local * 30, 3, 52),
                      FractalNoise(at.local * 30, 3, 53));
  const Vector3f p = at.local + 0.03f * bend;
  const Cell patch = ScatteredCell3(p / 0.03f, 54);
  F4 color = Mix(Rgb(.05f, .05f, .06f), Pick(kPaint, patch.hash), SoftStep(0.035f, 0.04f, patch.to_border));
  color = WithChips3(color, p, 0.011f, 0.25f, kSpot, at.texel_m, 55);
  return color * (0.85f + 0.3f * FractalNoise(at.local * 120, 2, 56));
}

F4 Glaze(const PaintedPoint& at) {
  static const F4 kFleck[] = {Rgb(.70f, .64f, .48f), Rgb(.22f, .40f, .52f), Rgb(.56f, .36f, .16f)};
  const float cloud = FractalNoise(at.local * 55, 4, 61);
  F4 color = Mix(Rgb(.012f, .045f, .13f), Rgb(.03f, .15f, .24f), cloud);
  color = WithChips3(color, at.local, 0.012f, 0.3f, kFleck, at.texel_m, 62);
  return WithChips3(color, at.local, 0.006f, 0.2f, kFleck, at.texel_m, 63);
}

// Printed strokes, blocks and dots of random sizes.
F4 Printed(const PaintedPoint& at) {
  static const F4 kInk[] = {Rgb(.05f, .06f, .09f), Rgb(.55f, .07f, .06f), Rgb(.06f, .18f, .38f)};
  const Vector3f grain_at(at.u_m * 220, at.v_m * 220, static_cast<float>(at.chart));
  const F4 paper = Rgb(.70f, .62f, .45f) * (0.9f + 0.2f * ValueNoise(grain_at, 71));
  F4 color = paper;
  const auto seed = static_cast<std::uint32_t>(72 + at.chart);
  // A coloured field behind part of the marks.
  if (UnitFloat(HashLattice(static_cast<int>(std::floor(at.v_m / 0.034f)), 0, 0, seed)) > 0.5f)
    color = Pick(kInk, HashLattice(static_cast<int>(std::floor(at.v_m / 0.034f)), 1, 0, seed)) * 1.6f;
  const bool dark_field = color[2] < 0.5f;
  for (const float cell_m : {0.0125f, 0.0068f}) {
    const float x = at.u_m / cell_m, y = at.v_m / cell_m;
    const float fx = std::floor(x), fy = std::floor(y);
    const std::uint32_t h =
        HashLattice(static_cast<int>(fx), static_cast<int>(fy), cell_m > 0.01f ? 1 : 2, seed);
    if (UnitFloat(h) < 0.42f) continue;
    const float cx = x - fx - 0.5f, cy = y - fy - 0.5f;
    const float angle = 6.2831853f * UnitFloat(Rehash(h + 3)), c = std::cos(angle), s = std::sin(angle);
    const float px = c * cx + s * cy, py = -s * cx + c * cy;
    const float a = 0.12f + 0.26f * UnitFloat(Rehash(h + 1)), b = 0.08f + 0.2f * UnitFloat(Rehash(h + 2));
    const bool dot = h % 3 == 0;
    const float inside = dot ? a - std::hypot(px, py) : std::min(a - std::abs(px), b - std::abs(py));
    const F4 ink = dark_field && h % 2 == 0 ? Rgb(.80f, .76f, .66f) : Pick(kInk, Rehash(h + 5));
    color = Mix(color, ink, SoftStep(0, at.texel_m / cell_m, inside));
  }
  return color;
}

F4 Label(const PaintedPoint& at) {
  static const F4 kBlock[] = {Rgb(.70f, .10f, .06f), Rgb(.84f, .78f, .62f), Rgb(.08f, .10f, .12f),
                              Rgb(.90f, .55f, .06f)};
  const float z = at.local.z();
  const float metal = 0.42f + 0.25f * ValueNoise({at.u_m * 40, at.v_m * 400, 0}, 81);
  if (at.chart != 0 || z < 0.008f || z > 0.122f) {
    static const F4 kDent[] = {Rgb(.16f, .16f, .17f), Rgb(.66f, .66f, .66f)};
    return WithChips(Rgb(metal, metal, metal * 1.02f), at.u_m, at.v_m, 0.012f, 0.4f, kDent, at.texel_m, 82);
  }
  // Rows of blocks of random widths, because hashes move the borders of cells.
  const float row_m = 0.0125f;
  const float row = std::floor(z / row_m);
  const float shift = UnitFloat(HashLattice(static_cast<int>(row), 3, 0, 83));
  const Cell block = ScatteredCell2(at.u_m / 0.016f + shift, row * 3.0f, 84);
  F4 color = Pick(kBlock, block.hash);
  const float in_row = z / row_m - row;
  if (block.hash % 4 == 1) {  // a mark inside the block
    const float mark = 0.18f + 0.2f * UnitFloat(Rehash(block.hash + 9));
    const float inside = std::min(mark - std::abs(in_row - 0.5f), mark - block.to_site);
    color = Mix(color, Pick(kBlock, Rehash(block.hash + 4)), SoftStep(0, at.texel_m / row_m, inside));
  }
  const float edge = std::min({in_row, 1 - in_row, block.to_border});
  return Mix(Rgb(.80f, .76f, .68f), color, SoftStep(0.07f, at.texel_m / row_m, edge));
}

F4 Patchwork(const PaintedPoint& at) {
  static const F4 kCloth[] = {Rgb(.78f, .36f, .07f), Rgb(.82f, .72f, .52f), Rgb(.36f, .08f, .07f),
                              Rgb(.86f, .58f, .16f), Rgb(.16f, .12f, .20f)};
  const Cell patch = ScatteredCell3(at.local / 0.02f, 91);
  const float weave = 0.85f + 0.3f * FractalNoise(at.local * 200, 2, 92);
  F4 color = Mix(Rgb(.9f, .86f, .78f), Pick(kCloth, patch.hash) * weave,
                 SoftStep(0.05f, at.texel_m / 0.02f, patch.to_border));
  return WithChips3(color, at.local, 0.0085f, 0.18f, kCloth, at.texel_m, 93);
}

F4 Banded(const PaintedPoint& at) {
  static const F4 kBand[] = {Rgb(.10f, .34f, .12f), Rgb(.78f, .70f, .20f), Rgb(.04f, .14f, .10f),
                             Rgb(.66f, .70f, .58f)};
  const Cell band = ScatteredCell2(at.u_m / 0.017f, std::floor(at.v_m / 0.035f) * 5.0f, 101);
  const F4 color = Mix(Rgb(.03f, .03f, .03f), Pick(kBand, band.hash), SoftStep(0.05f, 0.05f, band.to_border));
  return WithChips3(color, at.local, 0.0095f, 0.35f, kBand, at.texel_m, 102);
}

F4 RedTerrazzo(const PaintedPoint& at) {
  static const F4 kChip[] = {Rgb(.84f, .76f, .62f), Rgb(.10f, .05f, .06f), Rgb(.80f, .40f, .22f)};
  F4 color = Rgb(.48f, .06f, .05f) * (0.7f + 0.6f * FractalNoise(at.local * 90, 3, 111));
  color = WithChips3(color, at.local, 0.013f, 0.5f, kChip, at.texel_m, 112);
  return WithChips3(color, at.local, 0.0065f, 0.3f, kChip, at.texel_m, 113);
}

// Overlapping sheets of paper: one for each cell of a coarse grid, piled by hash.
F4 Posters(const PaintedPoint& at) {
  static const F4 kPaper[] = {Rgb(.70f, .62f, .46f), Rgb(.55f, .13f, .09f), Rgb(.09f, .22f, .38f),
                              Rgb(.80f, .76f, .68f), Rgb(.14f, .30f, .18f), Rgb(.06f, .06f, .08f)};
  constexpr float kGrid = 0.24f;
  const int gx = static_cast<int>(std::floor(at.u_m / kGrid)),
            gy = static_cast<int>(std::floor(at.v_m / kGrid));
  struct Sheet {
    std::uint32_t hash;  // also its height in the pile
    float x, y, cover;
  };
  std::vector<Sheet> sheets;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const std::uint32_t h = HashLattice(gx + dx, gy + dy, 0, 121);
      const float x = at.u_m - kGrid * (static_cast<float>(gx + dx) + UnitFloat(h));
      const float y = at.v_m - kGrid * (static_cast<float>(gy + dy) + UnitFloat(Rehash(h + 1)));
      const float angle = 0.8f * (UnitFloat(Rehash(h + 2)) - 0.5f), c = std::cos(angle), s = std::sin(angle);
      const float px = c * x + s * y, py = -s * x + c * y;
      const float inside = std::min(0.05f + 0.09f * UnitFloat(Rehash(h + 3)) - std::abs(px),
                                    0.05f + 0.09f * UnitFloat(Rehash(h + 4)) - std::abs(py));
      const float cover = SoftStep(0, 1.5f * at.texel_m, inside);
      if (cover > 0) sheets.push_back({h, px, py, cover});
    }
  std::sort(sheets.begin(), sheets.end(), [](const Sheet& a, const Sheet& b) { return a.hash < b.hash; });
  F4 color = Fieldstone(at);
  for (const Sheet& sheet : sheets) {
    F4 print =
        WithChips(Pick(kPaper, sheet.hash), sheet.x, sheet.y, 0.03f, 0.5f, kPaper, at.texel_m, sheet.hash);
    print = WithChips(print, sheet.x, sheet.y, 0.014f, 0.3f, kPaper, at.texel_m, sheet.hash + 1);
    color = Mix(color, print, sheet.cover);
  }
  return color;
}

// Tells whether a point of the sheet is dark, by a raster of a quarter of a millimetre, finer than any texel.
// Where a board is printed, in cells of a quarter of a millimetre.
class Ink {
 public:
  explicit Ink(const Board& board) : width_(Cells(board.WidthMm())), height_(Cells(board.HeightMm())) {
    ink_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    for (const RectangleMm& dark : board.Dark())
      for (int y = Cells(dark.y); y < Cells(dark.y + dark.height); ++y)
        for (int x = Cells(dark.x); x < Cells(dark.x + dark.width); ++x) ink_[Index(x, y)] = true;
  }
  bool At(double x_mm, double y_mm) const {
    const int x = static_cast<int>(std::floor(x_mm * kPerMm)),
              y = static_cast<int>(std::floor(y_mm * kPerMm));
    return x >= 0 && y >= 0 && x < width_ && y < height_ && ink_[Index(x, y)];
  }

 private:
  static constexpr int kPerMm = 4;
  static int Cells(double mm) { return static_cast<int>(std::lround(mm * kPerMm)); }
  std::size_t Index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  int width_, height_;
  std::vector<bool> ink_;
};

F4 OnSheet(const PaintedPoint& at, const Board& board, const Ink& printed) {
  const double x_mm = 1000 * static_cast<double>(at.local.x()) + 0.5 * board.WidthMm(),
               y_mm = 0.5 * board.HeightMm() - 1000 * static_cast<double>(at.local.z());
  int ink = 0;
  constexpr int kSide = 4;
  for (int j = 0; j < kSide; ++j)
    for (int i = 0; i < kSide; ++i)
      ink += printed.At(x_mm + ((i + 0.5) / kSide - 0.5) * 1000 * at.texel_m,
                        y_mm + ((j + 0.5) / kSide - 0.5) * 1000 * at.texel_m);
  return Mix(Rgb(.82f, .82f, .80f), Rgb(.04f, .04f, .04f), static_cast<float>(ink) / (kSide * kSide));
}

template <int kSheet>
F4 PrintedSheet(const PaintedPoint& at) {
  static const Board& board = MarkerSheet::BoardOf(kSheet);
  static const Ink printed(board);
  return OnSheet(at, board, printed);
}

F4 Stucco(const PaintedPoint& at) {
  return Rgb(.62f, .60f, .56f) * (0.98f + 0.04f * FractalNoise(at.local * 14, 2, 141));
}

F4 Porcelain(const PaintedPoint& at) {
  const Vector3f bend(FractalNoise(at.local * 45, 2, 151), FractalNoise(at.local * 45, 2, 152),
                      FractalNoise(at.local * 45, 2, 153));
  const Cell stroke = ScatteredCell3((at.local + 0.012f * bend) / 0.015f, 154);
  const F4 white = Rgb(.72f, .72f, .70f), blue = Rgb(.04f, .09f, .32f);
  if (UnitFloat(Rehash(stroke.hash)) > 0.4f) return white;
  return Mix(white, blue * (0.7f + 0.8f * UnitFloat(Rehash(stroke.hash + 2))),
             SoftStep(0.12f, at.texel_m / 0.015f, stroke.to_border));
}

// Veins from the middle to the rim, and spots.
F4 Leaf(const PaintedPoint& at) {
  static const F4 kSpot[] = {Rgb(.30f, .38f, .08f), Rgb(.05f, .12f, .03f), Rgb(.42f, .40f, .14f)};
  const float cloud = FractalNoise(at.local * 180, 2, 161);
  F4 color = Rgb(.10f, .26f, .06f) * (0.6f + 0.8f * cloud);
  const float angle = std::atan2(at.local.y(), at.local.x());
  const float vein = std::abs(std::sin(4 * angle)) * std::hypot(at.local.x(), at.local.y());
  color = Mix(Rgb(.38f, .46f, .18f), color, SoftStep(0.0008f, at.texel_m, vein));
  return WithChips3(color, at.local, 0.005f, 0.2f, kSpot, at.texel_m, 162);
}

F4 Bark(const PaintedPoint& at) {
  static const F4 kScar[] = {Rgb(.08f, .05f, .03f), Rgb(.40f, .32f, .22f)};
  const Vector3f along(at.local.x() * 500, at.local.y() * 500, at.local.z() * 90);
  const F4 color = Rgb(.21f, .14f, .08f) * (0.4f + 1.2f * FractalNoise(along, 3, 171));
  return WithChips3(color, at.local, 0.006f, 0.25f, kScar, at.texel_m, 172);
}

F4 Wood(const PaintedPoint& at) {
  static const F4 kBoard[] = {Rgb(.30f, .18f, .09f), Rgb(.36f, .23f, .12f), Rgb(.25f, .14f, .07f)};
  static const F4 kKnot[] = {Rgb(.10f, .05f, .03f), Rgb(.16f, .09f, .05f)};
  constexpr float kBoardM = 0.11f;
  const float row = std::floor(at.v_m / kBoardM), in_row = at.v_m / kBoardM - row;
  const std::uint32_t hash = HashLattice(static_cast<int>(row), 0, at.chart, 181);
  const Vector3f grain(at.u_m * 9 + static_cast<float>(hash % 101), at.v_m * 160, 0);
  F4 color = Pick(kBoard, hash) * (0.55f + 0.9f * FractalNoise(grain, 3, 182));
  color = WithChips(color, at.u_m, at.v_m, 0.05f, 0.12f, kKnot, at.texel_m, 183);
  const float gap = std::min(in_row, 1 - in_row);
  return Mix(Rgb(.04f, .03f, .02f), color, SoftStep(0.02f, at.texel_m / kBoardM, gap));
}

// Strokes of three sizes over sky, hills and a field.
F4 Painting(const PaintedPoint& at) {
  static const F4 kSky[] = {Rgb(.42f, .55f, .70f), Rgb(.62f, .66f, .68f), Rgb(.74f, .62f, .44f),
                            Rgb(.30f, .44f, .62f)};
  static const F4 kHill[] = {Rgb(.12f, .24f, .20f), Rgb(.20f, .32f, .18f), Rgb(.10f, .16f, .22f),
                             Rgb(.34f, .30f, .16f)};
  static const F4 kField[] = {Rgb(.62f, .50f, .14f), Rgb(.46f, .40f, .12f), Rgb(.66f, .30f, .10f),
                              Rgb(.24f, .34f, .10f)};
  const float height = at.local.z() + 0.05f * (FractalNoise({at.local.x() * 14, 0, 0}, 3, 191) - 0.5f);
  const auto& palette = height > 0.045f ? kSky : height > -0.02f ? kHill : kField;
  F4 color = Pick(palette, 7) * (0.6f + 0.8f * FractalNoise({at.u_m * 60, at.v_m * 60, 0}, 3, 192));
  const float lean = 0.5f * (at.u_m + at.v_m);
  color = WithChips(color, at.u_m + lean, 2 * at.v_m, 0.024f, 0.6f, palette, at.texel_m, 193);
  color = WithChips(color, at.u_m - lean, 2 * at.v_m, 0.012f, 0.5f, palette, at.texel_m, 194);
  return WithChips(color, at.u_m, at.v_m, 0.0065f, 0.35f, palette, at.texel_m, 195);
}

}  // namespace

const Board& MarkerSheet::BoardOf(int material) {
  static const Board on_easel = Board::Parse("aruco:3x4:45:9:DICT_4X4_50"),
                     on_turntable = Board::Parse("charuco:5x5:54:40:DICT_4X4_50");
  return material == material::kTurntableSheet ? on_turntable : on_easel;
}

F4 Reflectance(int material, const PaintedPoint& at) {
  using Paint = F4 (*)(const PaintedPoint&);
  static constexpr Paint kPaints[] = {Terrazzo,
                                      Fieldstone,
                                      Plaster,
                                      TileMosaic,
                                      Marbled,
                                      Glaze,
                                      Printed,
                                      Label,
                                      Patchwork,
                                      Banded,
                                      RedTerrazzo,
                                      Posters,
                                      PrintedSheet<material::kMarkerSheet>,
                                      Stucco,
                                      Porcelain,
                                      Leaf,
                                      Bark,
                                      Wood,
                                      Painting,
                                      PrintedSheet<material::kTurntableSheet>};
  F4 color = kPaints[material](at);
  for (int i = 0; i < 3; ++i) color[i] = std::clamp(color[i], 0.01f, 0.92f);
  return color;
}

}  // namespace ulf::acquisition
