#include "core/light_field/exchange/unread_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <string_view>
#include <vector>

#include "core/base/binary_file.h"
#include "core/base/lowercase.h"

namespace ulf {
namespace {

namespace fs = std::filesystem;

struct UnreadKind {
  std::string_view begins, ending;  // of the name, in lower case
  const char* what;
  const char* way_out;
  std::string_view holds = {};  // what its first bytes hold, where the name does not tell
};

// Sorted by how much a file tells: a database lies beside many other sets.
constexpr UnreadKind kUnreadKinds[] = {
    {"", ".abc", "Alembic, as of Meshroom",
     "take cameras.sfm of Meshroom's node StructureFromMotion, or let its node ConvertSfMFormat write one"},
    {"", ".mg", "a project of Meshroom",
     "give the folder of its node StructureFromMotion (below MeshroomCache), which holds cameras.sfm"},
    {"", ".psx", "a project of Metashape",
     "export its cameras: File > Export > Export Cameras, as Agisoft XML"},
    {"", ".psz", "a project of Metashape",
     "export its cameras: File > Export > Export Cameras, as Agisoft XML"},
    {"", ".rcproj", "a project of RealityCapture",
     "export its cameras: Alignment > Export > Registration > Internal/External camera parameters"},
    {"", ".rsproj", "a project of RealityScan",
     "export its cameras: Alignment > Export > Registration > Internal/External camera parameters"},
    {"sfm_data", ".bin", "openMVG's binary form",
     "openMVG_main_ConvertSfM_DataFormat makes an sfm_data.json of it"},
    {"sfm_data", ".xml", "openMVG's XML", "openMVG_main_ConvertSfM_DataFormat makes an sfm_data.json of it"},
    {"", ".mvs", "a scene of OpenMVS", "its program InterfaceCOLMAP makes a set of COLMAP of it"},
    {"", ".r3d", "a recording of Record3D",
     "nerfstudio's 'ns-process-data record3d' makes a folder with transforms.json of it"},
    {"", ".p4d", "a project of Pix4D",
     "open its photographs in COLMAP, Meshroom or Metashape, and take that set"},
    {"", "_calibrated_camera_parameters.txt", "cameras of Pix4D",
     "open its photographs in COLMAP, Meshroom or Metashape, and take that set"},
    {"", ".xml", "a block of photographs for iTwin Capture (ContextCapture)",
     "let the program that wrote it export COLMAP's format or Agisoft XML", "<BlocksExchange"},
    {"metadata", "metadata", "an unpacked recording of Record3D",
     "instant-ngp's scripts/record3d2nerf.py writes a transforms.json beside it"},
    {"bbox", ".txt", "a set of NSVF",
     "instant-ngp's scripts/nsvf2nerf.py writes a transforms_train.json beside it"},
    {"cameras", ".npz", "cameras of IDR and NeuS",
     "NeuS2's tools/data_format_from_neus.py makes a folder with transforms.json of them"},
    {"", ".pose.txt", "poses of 7-Scenes, camera to world with y down and z forward",
     "write them with columns 2 and 3 negated into the frames of a transforms.json"},
    {"", "_colmap_sfm.log", "poses of Tanks and Temples, camera to world with y down and z forward",
     "write them with columns 2 and 3 negated into the frames of a transforms.json"},
    {"", ".sens", "a recording of ScanNet",
     "its SensReader writes photographs and poses, camera to world with y down and z forward: write these "
     "with columns 2 and 3 negated into the frames of a transforms.json"},
    {"", ".blend", "a scene of Blender", "the add-on BlenderNeRF writes photographs with their poses of it"},
    {"pair", ".txt", "a set of MVSNet", "give the COLMAP model of which it was made"},
    {"database", ".db", "COLMAP's database, which holds no poses", "'colmap mapper' makes a model of it"},
};

bool IsOfKind(const UnreadKind& kind, const fs::path& file) {
  const std::string name = Lowercase(file.filename().string());
  if (!name.starts_with(kind.begins) || !name.ends_with(kind.ending)) return false;
  if (kind.holds.empty()) return true;
  constexpr std::size_t kEnough = 4096;
  std::ifstream stream(file, std::ios::binary);
  return BytesAt(stream, 0, kEnough).find(kind.holds) != std::string::npos;
}

}  // namespace

std::string UnreadSet(const fs::path& source) {
  std::error_code unknown;
  std::vector<fs::path> files;
  if (fs::is_regular_file(source, unknown)) files.push_back(source);
  if (!files.empty() && Lowercase(source.extension().string()) == ".zip")
    return fmt::format("{}: packed; unpack it and give the folder", source.string());
  for (const auto& entry : fs::directory_iterator(source, unknown))
    if (entry.is_regular_file(unknown)) files.push_back(entry.path());
  std::ranges::sort(files);
  for (const UnreadKind& kind : kUnreadKinds)
    for (const fs::path& file : files)
      if (IsOfKind(kind, file))
        return fmt::format("{}: {}, which is not read; {}", file.string(), kind.what, kind.way_out);
  return {};
}

}  // namespace ulf
