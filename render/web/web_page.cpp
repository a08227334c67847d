#include "render/web/web_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/image/files/picture_codecs.h"
#include "core/light_field/exchange/staged_folder.h"
#include "core/light_field/formats/xml_file.h"
#include "render/fields/field_options.h"
#include "render/fields/lumigraph_field.h"
#include "render/fields/mesh_field.h"
#include "render/proxy/mesh_resolution.h"
#include "render/viewer/viewer_camera.h"
#include "render/web/embedded_page.h"
#include "render/web/web_file.h"
#include "render/web/web_pictures.h"

namespace ulf::render {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::ordered_json;

// Share of the budget, limited by what a phone draws quickly.
constexpr double kGeometryShare = 0.05;
constexpr std::size_t kMostGeometryBytes = 300'000;
// Divisor of the triangles that the first picture and small moving ones use.
constexpr std::size_t kCoarseDivisor = 2;
constexpr std::size_t kFirstViews = 12;           // their small pictures are shown first
constexpr std::size_t kFileBytes = 700'000;       // approximate size of the files after the first
constexpr std::size_t kBytesOfFileList = 64;      // limit of a file's entry in the scene's header
constexpr std::size_t kBytesOfPictureEntry = 32;  // limit of a picture's entry in a file's header

constexpr std::size_t kBytesOfPlaces = 1500;  // limit of arrays in headers

struct NamedFile {
  std::string name, text;
};

template <typename Vector>
Json JsonOf(const Vector& vector) {
  return {vector.x(), vector.y(), vector.z()};
}

std::vector<float> Floats(const std::vector<Vector3d>& vectors) {
  std::vector<float> floats;
  for (const Vector3d& vector : vectors)
    for (const double value : vector) floats.push_back(static_cast<float>(value));
  return floats;
}

std::vector<std::uint32_t> Indices(const std::vector<Triangle>& triangles) {
  std::vector<std::uint32_t> indices;
  for (const Triangle& triangle : triangles)
    for (const int corner : triangle) indices.push_back(static_cast<std::uint32_t>(corner));
  return indices;
}

// Everything is relative to the subject's centre, because browsers draw in 32 bits.
WebArrays FieldArrays(const RenderScene& scene, const std::vector<WebPicture>& pictures) {
  const Vector3d& center = scene.subject.center_in_world;
  WebArrays arrays;
  std::vector<float>
      cameras;  // per view: fx fy cx cy of a picture of size 1, width, height, cam_from_world by rows
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const CameraModel& camera = pictures[i].camera;
    Rigid3 cam_from_center = scene.views[i].cam_from_world;
    cam_from_center.translation = cam_from_center * center;
    const Eigen::Matrix3d r = cam_from_center.RotationMatrix();
    for (const double value : {camera.fx / camera.width, camera.fy / camera.height, camera.cx / camera.width,
                               camera.cy / camera.height, 1.0 * camera.width, 1.0 * camera.height})
      cameras.push_back(static_cast<float>(value));
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) cameras.push_back(static_cast<float>(r(row, column)));
      cameras.push_back(static_cast<float>(cam_from_center.translation(row)));
    }
  }
  arrays.Add("cameras", cameras);
  const FieldOptions drawn = DefaultField(scene);
  if (!UsesMesh(drawn.kind)) return arrays;  // the page computes lumigraph weights

  const FieldMesh field = MakeFieldMesh(scene.mesh, drawn.level);
  std::vector<Vector3d> positions;
  for (const Vector3d& position : field.positions) positions.push_back(position - center);
  arrays.Add("positions", Floats(positions));
  arrays.Add("triangles", Indices(field.triangles));
  std::vector<std::uint32_t> first_weight, weight_vertex;
  std::vector<float> weight;
  for (const SparseWeights& weights : field.weights) {
    first_weight.push_back(static_cast<std::uint32_t>(weight.size()));
    for (const auto& [vertex, share] : weights) {
      weight_vertex.push_back(static_cast<std::uint32_t>(vertex));
      weight.push_back(static_cast<float>(share));
    }
  }
  first_weight.push_back(static_cast<std::uint32_t>(weight.size()));
  arrays.Add("firstWeight", first_weight);
  arrays.AddIndices("weightVertex", weight_vertex);
  arrays.Add("weight", weight);

  std::vector<std::uint32_t> first_view, views;
  for (const ViewpointMesh::Vertex& vertex : scene.mesh.vertices) {
    first_view.push_back(static_cast<std::uint32_t>(views.size()));
    for (const int view : vertex.views) views.push_back(static_cast<std::uint32_t>(view));
  }
  first_view.push_back(static_cast<std::uint32_t>(views.size()));
  arrays.Add("firstViewOfVertex", first_view);
  arrays.Add("viewOfVertex", views);
  arrays.Add("hull", Indices(scene.mesh.triangles));
  return arrays;
}

struct Geometry {
  std::string file;  // empty: there is none
  std::size_t triangles = 0;
};

// Stores positions as 16 bits of a cube around the mesh.
Geometry GeometryFile(const TriangleMesh& mesh, const Vector3d& center, bool coarse) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& vertex : mesh.vertices) box.extend(vertex);
  const Eigen::Vector3f size = box.sizes().cwiseMax(1e-12f);
  constexpr float kMost = 65535;
  std::vector<std::uint16_t> places;
  for (const Eigen::Vector3f& vertex : mesh.vertices)
    for (const float value : Eigen::Vector3f((vertex - box.min()).cwiseQuotient(size) * kMost))
      places.push_back(static_cast<std::uint16_t>(std::lround(value)));
  WebArrays arrays;
  arrays.Add("places", places);
  std::vector<std::uint32_t> corners;
  for (const auto& triangle : mesh.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
  arrays.AddIndices("corners", corners);
  const Json frame{{"low", JsonOf(Vector3d(box.min().cast<double>() - center))},
                   {"step", JsonOf(Vector3d(size.cast<double>() / kMost))}};
  const Json header{
      {"kind", "geometry"}, {"coarse", coarse}, {"geometry", frame}, {"arrays", arrays.places()}};
  return {WebFileText(header, arrays.bytes()), mesh.triangles.size()};
}

struct PageGeometry {
  Geometry first, fine;  // no fine one if the mesh is small
  std::size_t triangles_before = 0;
};

PageGeometry GeometryOf(const RenderScene& scene, std::size_t most_bytes) {
  PageGeometry geometry;
  const auto occluder = scene.proxy->Occluder();
  if (!occluder || occluder->triangles.empty()) {
    geometry.first.file = WebFileText(
        {{"kind", "geometry"}, {"coarse", false}, {"geometry", nullptr}, {"arrays", Json::object()}}, "");
    return geometry;
  }
  const Vector3d& center = scene.subject.center_in_world;
  geometry.triangles_before = occluder->triangles.size();
  constexpr std::size_t kBytesOfTriangle = 12;  // 3 indices of 16 bits and half a vertex, in base64
  MeshSimplification simplification{
      .center_in_world = center,
      .even_within = std::max(scene.mesh.median_distance, scene.subject.radius),
      .most_triangles = std::max<std::size_t>(500, most_bytes / kBytesOfTriangle)};
  if (!(simplification.even_within > 0)) simplification.even_within = 1;
  const TriangleMesh fine = Simplified(*occluder, simplification);
  simplification.most_triangles /= kCoarseDivisor;
  if (fine.triangles.size() <= simplification.most_triangles) {
    geometry.first = GeometryFile(fine, center, false);
    return geometry;
  }
  geometry.first = GeometryFile(Simplified(*occluder, simplification), center, true);
  geometry.fine = GeometryFile(fine, center, false);
  return geometry;
}

// Takes the first few as they are, then each as far as possible from earlier ones: any prefix is spread over
// all.
std::vector<std::size_t> Spread(const RenderScene& scene, const std::vector<std::size_t>& by_distance,
                                std::size_t first) {
  std::vector<std::size_t> order;
  std::vector<double> distance(scene.views.size(), INFINITY);
  std::vector<bool> taken(scene.views.size(), false);
  while (order.size() < by_distance.size()) {
    const std::size_t next = order.size() < first
                                 ? by_distance[order.size()]
                                 : *std::ranges::max_element(by_distance, {}, [&](std::size_t i) {
                                     return taken[i] ? -1.0 : distance[i];
                                   });
    taken[next] = true;
    order.push_back(next);
    for (std::size_t i = 0; i < distance.size(); ++i)
      distance[i] =
          std::min(distance[i], (scene.views[i].center_in_world - scene.views[next].center_in_world).norm());
  }
  return order;
}

// Adds files of pictures of about kFileBytes each.
void AddPictureFiles(const std::vector<WebPicture>& pictures, const std::vector<std::size_t>& order,
                     bool fine, std::vector<NamedFile>& files) {
  Json views = Json::array();
  WebBytes bytes;
  int number = 0;
  const auto close = [&] {
    if (views.empty()) return;
    files.push_back({fmt::format("data/{}_{:03d}.js", fine ? "fine" : "small", number++),
                     WebFileText({{"kind", fine ? "fine" : "small"}, {"views", views}}, bytes.bytes())});
    views = Json::array();
    bytes = WebBytes();
  };
  for (const std::size_t view : order) {
    const std::string& picture = fine ? pictures[view].fine : pictures[view].small;
    views.push_back({view, bytes.Add(picture), picture.size()});
    if (WebFileSize(0, bytes.bytes().size()) >= kFileBytes) close();
  }
  close();
}

constexpr const char* kPosterFile = "poster.webp";

// Writes the inputs of page/orbit.ts for the poster's zoom: a photograph's width, height and focal length,
// and the subject's width at the distance of the camera.
std::string PosterHtml(const ViewerCamera& start, double radius) {
  const CameraModel& lens = start.photograph;
  return fmt::format(
      R"(<img id="poster" src="{}" alt="" elementtiming="poster" data-lens="{} {} {:.6g}" data-subject="{:.6g} {:.6g}">)",
      kPosterFile, lens.width, lens.height, lens.MeanFocalPx(), radius, start.Distance());
}

std::string PosterBytes(const cv::Mat& poster) {
  constexpr int kPosterQuality = 75;  // Guessed.
  return poster.empty() ? std::string() : WebpBytes(poster, kPosterQuality);
}

std::string PageHtml(const std::string& title, const std::string& poster) {
  std::string html = page::k_index_html;
  const auto put = [&](const std::string& mark, const std::string& text) {
    for (std::size_t at = html.find(mark); at != std::string::npos; at = html.find(mark, at + text.size()))
      html.replace(at, mark.size(), text);
  };
  put("{{style}}", page::k_page_css);
  put("{{poster}}", poster);
  put("{{title}}", XmlEscaped(title));
  return html;
}

Json SceneHeader(const RenderScene& scene, const WebPageOptions& options, const ViewerCamera& start,
                 const std::vector<WebPicture>& pictures) {
  const bool masks = std::ranges::any_of(pictures, &WebPicture::has_gaps);
  int width = 1, height = 1;
  for (const WebPicture& picture : pictures) {
    width = std::max(width, picture.camera.width);
    height = std::max(height, picture.camera.height);
  }
  const FieldOptions field = DefaultField(scene);
  const Vector3d& center = scene.subject.center_in_world;
  return {{"kind", "scene"},
          {"title", options.title},
          {"views", scene.views.size()},
          {"picture", {width, height}},
          {"small", kSmallWebPictureDivisor},
          {"radius", scene.subject.radius},
          {"up", JsonOf(start.up_in_world)},
          {"eye", JsonOf(Vector3d(start.eye_in_world - center))},
          {"lens", {start.photograph.width, start.photograph.height, start.photograph.MeanFocalPx()}},
          {"spacing", scene.mesh.mean_edge_rad},
          {"lumigraphViews", field.lumigraph_k},
          {"lumigraphResolution", field.lumigraph_resolution},
          {"feather", kFeatherShare},
          {"masks", masks}};
}

// Estimates the bytes that follow from the number of views alone: their cameras, the blending field, the
// lists of pictures and files.
std::size_t BytesOfViews(const RenderScene& scene, std::size_t header_bytes, std::size_t budget_bytes) {
  const std::vector<WebPicture> none(scene.views.size());
  return WebFileSize(header_bytes, FieldArrays(scene, none).bytes().size()) +
         2 * scene.views.size() * kBytesOfPictureEntry +
         (budget_bytes / kFileBytes + 8) * 2 * kBytesOfFileList + kBytesOfPlaces;
}

// Makes the scene as LoadScene() does, without photographs.
RenderScene SceneOfCameras(const LightField& light_field, const SceneOptions& options) {
  RenderScene scene;
  scene.subject = SubjectOf(light_field, options.subject);
  scene.up_in_world = options.up_in_world.value_or(light_field.UpInWorld());
  scene.mesh_in_plane = options.mesh_in_plane;
  for (const View& view : light_field.views) {
    SceneView& out = scene.views.emplace_back();
    out.cam_from_world = view.cam_from_world;
    out.center_in_world = view.CenterInWorld();
  }
  scene.MakeMesh();
  return scene;
}

}  // namespace

LeastWebPage LeastPageOf(const LightField& light_field, const SceneOptions& options,
                         std::size_t budget_bytes) {
  LeastWebPage least{.views = light_field.views.size()};
  if (light_field.views.empty()) return least;
  const std::size_t page = PageHtml("", "").size() + std::string_view(page::k_page_js).size();
  const std::size_t of_views = BytesOfViews(SceneOfCameras(light_field, options), 0, budget_bytes) +
                               WebFileSize(0, least.views * kLeastWebPicture);
  least.bytes = page + of_views;
  if (budget_bytes > page)
    least.views_held =
        static_cast<std::size_t>(static_cast<double>(budget_bytes - page) / static_cast<double>(of_views) *
                                 static_cast<double>(least.views));
  return least;
}

WebPageSummary ExportWebPage(const RenderScene& scene, const std::filesystem::path& out,
                             const WebPageOptions& options) {
  StagedFolder folder(out);
  const ViewerCamera start = StartingCamera(scene);
  const std::vector<int> views = ViewsByDistance(scene, start.eye_in_world);
  const std::vector<std::size_t> by_distance(views.begin(), views.end());
  const std::vector<std::size_t> spread = Spread(scene, by_distance, kFirstViews);

  const std::string poster = PosterBytes(options.poster);
  std::vector<NamedFile> files{
      {"index.html", PageHtml(options.title, poster.empty() ? "" : PosterHtml(start, scene.subject.radius))},
      {"page.js", page::k_page_js}};
  if (!poster.empty()) files.push_back({kPosterFile, poster});
  const auto geometry_bytes =
      std::min(kMostGeometryBytes,
               static_cast<std::size_t>(kGeometryShare * static_cast<double>(options.budget_bytes)));
  const PageGeometry geometry = GeometryOf(scene, geometry_bytes);

  // Pictures may use the rest of the budget.
  const std::vector<WebPicture> none(scene.views.size());
  std::size_t taken =
      BytesOfViews(scene, SceneHeader(scene, options, start, none).dump().size(), options.budget_bytes) +
      geometry.first.file.size() + geometry.fine.file.size();
  for (const NamedFile& file : files) taken += file.text.size();
  if (taken >= options.budget_bytes)
    throw Refusal(
        fmt::format("a budget of {:.3g} MB is too little", 1e-6 * static_cast<double>(options.budget_bytes)),
        "",
        fmt::format("page, cameras and geometry alone take {:.3g} MB, and pictures come on top of it",
                    1e-6 * static_cast<double>(taken)),
        "give some times as much");
  WebPictures pictures = MakeWebPictures(scene, {.most_bytes = (options.budget_bytes - taken) / 4 * 3,
                                                 .longest_px = options.longest_px,
                                                 .progress = options.progress,
                                                 .stop = options.stop});

  std::vector<NamedFile> later;
  if (!geometry.fine.file.empty()) later.push_back({"data/geometry_fine.js", geometry.fine.file});
  const std::size_t first = std::min(kFirstViews, spread.size());
  const auto split = spread.begin() + static_cast<std::ptrdiff_t>(first);
  std::vector<NamedFile> of_first;
  AddPictureFiles(pictures.views, {spread.begin(), split}, false, of_first);
  AddPictureFiles(pictures.views, {split, spread.end()}, false, later);
  AddPictureFiles(pictures.views, by_distance, true, later);

  Json header = SceneHeader(scene, options, start, pictures.views);
  Json list = Json::array();
  for (const NamedFile& file : later) list.push_back({file.name, file.text.size()});
  header["files"] = list;
  const WebArrays field = FieldArrays(scene, pictures.views);
  header["arrays"] = field.places();
  files.push_back({"data/scene.js", WebFileText(header, field.bytes())});
  files.push_back({"data/geometry.js", geometry.first.file});
  files.push_back({"data/first.js", ""});
  for (const NamedFile& file : of_first) files.back().text += file.text;

  WebPageSummary summary{.views = scene.views.size(),
                         .width = header["picture"][0],
                         .height = header["picture"][1],
                         .quality = pictures.quality,
                         .triangles = std::max(geometry.first.triangles, geometry.fine.triangles),
                         .triangles_before = geometry.triangles_before};
  for (const NamedFile& file : files) summary.first_bytes += file.text.size();
  files.insert(files.end(), std::make_move_iterator(later.begin()), std::make_move_iterator(later.end()));
  summary.files = files.size();
  MakeFolder(folder.path() / "data");
  FileBatch batch;
  for (const NamedFile& file : files) {
    summary.bytes += file.text.size();
    batch.Write(folder.path() / file.name, ContentOf(file.text));
  }
  batch.Commit();
  folder.Commit();
  return summary;
}

}  // namespace ulf::render
