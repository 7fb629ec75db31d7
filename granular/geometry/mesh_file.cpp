// SPDX-License-Identifier: MIT
#include "granular/geometry/mesh_file.h"

#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstring>
#include <exception>
#include <fstream>
#include <iomanip>
#include <limits>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "granular/base/require.h"
#include "granular/geometry/detail/child_process.h"
#include "granular/geometry/detail/cut_polygon.h"

namespace granular {
namespace {

constexpr unsigned kMostCorners =
    2000;  // of a polygon: more than any modeller makes, and cutting them would take seconds
constexpr int kMaxNodeDepth = 200;  // of the tree of parts; deeper ones are damage, and recursion must end
constexpr std::int64_t kStlHeader = 84;          // bytes: 80 of text and the count
constexpr std::int64_t kStlTriangle = 50;        // bytes: normal, three corners, attribute
constexpr std::size_t kLongestHeader = 1 << 16;  // bytes of a PLY header that are looked at

[[noreturn]] void refuse(const std::filesystem::path& path, const std::string& what) {
  throw std::runtime_error("mesh file " + path.string() + ": " + what);
}

std::string lowerCaseExtension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

std::string oneLine(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

std::int64_t checkFile(const std::filesystem::path& path, const MeshFileLimits& limits) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) refuse(path, "no such file");
  if (!std::filesystem::is_regular_file(path, error)) refuse(path, "not a regular file");
  const auto size = static_cast<std::int64_t>(std::filesystem::file_size(path, error));
  if (error || !std::ifstream(path, std::ios::binary)) refuse(path, "cannot be read");
  if (size == 0) refuse(path, "the file is empty");
  if (size > limits.maxBytes) {
    refuse(path, std::to_string(size) + " bytes; the limit is " + std::to_string(limits.maxBytes) +
                     " (MeshFileLimits.maxBytes)");
  }
  return size;
}

/// The first bytes of a file, as far as it goes.
std::string readStart(const std::filesystem::path& path, std::size_t most) {
  std::string start(most, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(most));
  start.resize(static_cast<std::size_t>(file.gcount()));
  return start;
}

/// Refuses a count that a file of this size cannot hold.
void requireRoom(const std::filesystem::path& path, const char* what, double count, double bytesEach,
                 std::int64_t bytes) {
  if (count * bytesEach <= static_cast<double>(bytes)) return;
  std::ostringstream text;
  text << "damaged or truncated: it announces " << std::fixed << std::setprecision(0) << count << ' ' << what
       << ", which do not fit into its " << bytes << " bytes";
  refuse(path, text.str());
}

void checkStl(const std::filesystem::path& path, std::int64_t size) {
  const std::string start = readStart(path, kLongestHeader);
  if (start.starts_with("solid") && start.find("facet") != std::string::npos)
    return;  // text: nothing is announced
  if (size < kStlHeader)
    refuse(path, "truncated: a binary STL file has at least 84 bytes, this one " + std::to_string(size));
  std::uint32_t count = 0;
  for (int b = 3; b >= 0; --b) count = count << 8 | static_cast<unsigned char>(start[80 + b]);
  requireRoom(path, "triangles", count, kStlTriangle, size - kStlHeader);
}

/// Bytes of one value of a PLY type; 0 for a type there is not.
double plyBytes(const std::string& type) {
  static const std::map<std::string, double> kBytes = {
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto known = kBytes.find(type);
  return known == kBytes.end() ? 0.0 : known->second;
}

/// What a PLY header announces: how many of an element, and the fewest bytes each takes.
struct PlyElement {
  std::string name;
  double count = 0.0, bytes = 0.0;
};

PlyElement readPlyElement(const std::filesystem::path& path, const std::string& line) {
  std::istringstream words(line);
  std::string keyword;
  PlyElement element;
  words >> keyword >> element.name >> element.count;
  const bool isName = std::all_of(element.name.begin(), element.name.end(),
                                  [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-'; });
  if (!words || element.count < 0.0 || !isName) refuse(path, "damaged PLY header: '" + oneLine(line) + "'");
  return element;
}

/// Fewest bytes of one property: a list counts by its length alone, text by one digit and a blank.
double readPlyProperty(const std::filesystem::path& path, const std::string& line, bool isText) {
  std::istringstream words(line);
  std::string keyword, type;
  words >> keyword >> type;
  if (type == "list") words >> type;
  const double bytes = plyBytes(type);
  if (bytes == 0.0) refuse(path, "damaged PLY header: '" + oneLine(line) + "'");
  return isText ? 2.0 : bytes;
}

std::vector<PlyElement> readPlyHeader(const std::filesystem::path& path) {
  std::istringstream header(readStart(path, kLongestHeader));
  std::vector<PlyElement> elements;
  bool isText = false;
  for (std::string line; std::getline(header, line);) {
    const std::string word = line.substr(0, line.find_first_of(" \t\r"));
    if (word == "end_header") return elements;
    if (word == "format") isText = line.find("ascii") != std::string::npos;
    if (word == "element") elements.push_back(readPlyElement(path, line));
    if (word == "property" && !elements.empty()) elements.back().bytes += readPlyProperty(path, line, isText);
  }
  refuse(path, "damaged PLY header: no end_header");
}

void checkPly(const std::filesystem::path& path, std::int64_t size) {
  bool hasVertices = false, hasFaces = false;
  double total = 0.0;
  for (const PlyElement& element : readPlyHeader(path)) {
    requireRoom(path, element.name.c_str(), element.count, std::max(element.bytes, 1.0), size);
    total += element.count * element.bytes;
    hasVertices = hasVertices || element.name == "vertex";
    hasFaces = hasFaces || element.name == "face" || element.name == "tristrips";
  }
  requireRoom(path, "bytes of elements", total, 1.0, size + 1);  // the last line may lack its end
  if (!hasVertices || !hasFaces)
    refuse(path, "there are no triangles: the PLY header names no vertices or no faces");
}

/// The lines of a text file that are neither empty nor a comment.
class Lines {
 public:
  explicit Lines(const std::filesystem::path& path) : file_(path, std::ios::binary) {}

  bool next() {
    while (std::getline(file_, text)) {
      text.erase(std::min(text.find('#'), text.size()));
      if (text.find_first_not_of(" \t\r") != std::string::npos) return true;
    }
    return false;
  }

  std::string text;

 private:
  std::ifstream file_;
};

/// assimp bends an index out of range to the last vertex without a word.
void checkOffIndices(const std::filesystem::path& path, Lines& lines, std::int64_t vertices,
                     std::int64_t faces) {
  for (std::int64_t v = 0; v < vertices; ++v) {
    if (!lines.next())
      refuse(path, "truncated: " + std::to_string(v) + " of " + std::to_string(vertices) + " vertices");
  }
  for (std::int64_t f = 0; f < faces; ++f) {
    if (!lines.next())
      refuse(path, "truncated: " + std::to_string(f) + " of " + std::to_string(faces) + " faces");
    std::istringstream words(lines.text);
    std::int64_t corners = 0, index = 0;
    if (!(words >> corners))
      refuse(path, "damaged: face " + std::to_string(f) + " is '" + oneLine(lines.text) + "'");
    for (std::int64_t c = 0; c < corners; ++c) {
      if (!(words >> index) || index < 0 || index >= vertices) {
        refuse(path, "damaged: face " + std::to_string(f) + " names a vertex that does not exist");
      }
    }
  }
}

void checkOff(const std::filesystem::path& path, std::int64_t size) {
  Lines lines(path);
  const auto letters = lines.next() ? lines.text.find("OFF") : std::string::npos;
  if (letters == std::string::npos) refuse(path, "no OFF header");
  const bool countsFollow = lines.text.find_first_of("0123456789", letters) == std::string::npos;
  if (countsFollow && !lines.next()) refuse(path, "no counts after the OFF header");
  const std::size_t start = countsFollow ? 0 : letters + std::strlen("OFF");
  std::istringstream words(lines.text.substr(start));
  std::int64_t vertices = 0, faces = 0;
  if (!(words >> vertices >> faces) || vertices < 0 || faces < 0)
    refuse(path, "damaged OFF counts: '" + oneLine(lines.text) + "'");
  requireRoom(path, "vertices", static_cast<double>(vertices), 6.0, size + 1);  // "0 0 0\n"
  requireRoom(path, "faces", static_cast<double>(faces), 8.0, size + 1);        // "3 0 1 2\n"
  checkOffIndices(path, lines, vertices, faces);
}

/// What is cheap to see before a parser trusts the file: counts that its size cannot hold.
void checkAnnouncedCounts(const std::filesystem::path& path, std::int64_t size) {
  const std::string extension = lowerCaseExtension(path);
  if (extension == ".stl") return checkStl(path, size);
  if (extension == ".ply") return checkPly(path, size);
  if (extension == ".off") return checkOff(path, size);
  for (const char* known : {".obj", ".gltf", ".glb", ".dae"}) {
    if (extension == known) return;
  }
  refuse(path,
         "unknown kind of file '" + extension + "'; it must be .obj, .stl, .ply, .off, .gltf, .glb or .dae");
}

/// Puts the parts of an imported scene together.
class Assembler {
 public:
  Assembler(const std::filesystem::path& path, const aiScene& scene, const MeshFileLimits& limits)
      : path_(path), scene_(scene), limits_(limits) {}

  TriangleMesh run() {
    addNode(*scene_.mRootNode, aiMatrix4x4(), 0);
    return std::move(mesh_);
  }

 private:
  void addNode(const aiNode& node, const aiMatrix4x4& parent, int depth) {
    if (depth > kMaxNodeDepth)
      refuse(path_, "parts are nested more than " + std::to_string(kMaxNodeDepth) + " deep");
    const aiMatrix4x4 toWorld = parent * node.mTransformation;
    for (unsigned m = 0; m < node.mNumMeshes; ++m) {
      if (node.mMeshes[m] >= scene_.mNumMeshes)
        refuse(path_, "damaged: a part names a mesh that does not exist");
      addPart(*scene_.mMeshes[node.mMeshes[m]], toWorld);
    }
    for (unsigned c = 0; c < node.mNumChildren; ++c) addNode(*node.mChildren[c], toWorld, depth + 1);
  }

  void addPart(const aiMesh& part, const aiMatrix4x4& toWorld) {
    if (mesh_.vertices.size() + part.mNumVertices > std::size_t{std::numeric_limits<std::int32_t>::max()}) {
      refuse(path_, "more vertices than an index can name");
    }
    const auto first = static_cast<std::int32_t>(mesh_.vertices.size());
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D p = toWorld * part.mVertices[v];
      mesh_.vertices.emplace_back(p.x, p.y, p.z);
      if (!mesh_.vertices.back().allFinite())
        refuse(path_, "vertex " + std::to_string(first + v) + " is not finite");
    }
    const bool isMirrored = toWorld.Determinant() < 0.0f;
    for (unsigned f = 0; f < part.mNumFaces; ++f) addFace(part, part.mFaces[f], first, isMirrored);
  }

  /// Points and lines are left out; polygons are cut here, since assimp's own step stops the program on some
  /// damaged files.
  void addFace(const aiMesh& part, const aiFace& face, std::int32_t first, bool isMirrored) {
    if (face.mNumIndices < 3) return;
    if (face.mNumIndices > kMostCorners)
      refuse(path_, "a polygon of " + std::to_string(face.mNumIndices) + " corners");
    std::vector<std::int32_t> corners;
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      if (face.mIndices[k] >= part.mNumVertices)
        refuse(path_, "damaged: a face names a vertex that does not exist");
      corners.push_back(first + static_cast<std::int32_t>(face.mIndices[k]));
    }
    if (isMirrored) std::reverse(corners.begin(), corners.end());
    if (corners.size() == 3) return addTriangle({corners[0], corners[1], corners[2]});
    std::vector<Vector3> points;
    for (std::int32_t c : corners) points.push_back(mesh_.vertices[c]);
    for (const auto& t : detail::cutPolygon(points))
      addTriangle({corners[t[0]], corners[t[1]], corners[t[2]]});
  }

  void addTriangle(const std::array<std::int32_t, 3>& corners) {
    if (std::ssize(mesh_.triangles) >= limits_.maxTriangles) {
      refuse(path_, "more than " + std::to_string(limits_.maxTriangles) +
                        " triangles (MeshFileLimits.maxTriangles)");
    }
    mesh_.triangles.push_back(corners);
  }

  const std::filesystem::path& path_;
  const aiScene& scene_;
  const MeshFileLimits& limits_;
  TriangleMesh mesh_;
};

/// The scene belongs to the importer.
const aiScene& import(Assimp::Importer& importer, const std::filesystem::path& path) {
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(path.string(), 0);
  } catch (const std::exception& error) {
    refuse(path, std::string("cannot be parsed: ") + oneLine(error.what()));
  }
  if (!scene) refuse(path, "cannot be parsed: " + oneLine(importer.GetErrorString()));
  if (!scene->mRootNode || (scene->mFlags & AI_SCENE_FLAGS_INCOMPLETE))
    refuse(path, "there are no triangles");
  return *scene;
}

template <class Item>
void appendBytes(const std::vector<Item>& items, std::string& bytes) {
  const std::uint64_t count = items.size();
  bytes.append(reinterpret_cast<const char*>(&count), sizeof count);
  if (count > 0) bytes.append(reinterpret_cast<const char*>(items.data()), count * sizeof(Item));
}

template <class Item>
std::vector<Item> takeBytes(std::string_view& bytes) {
  std::uint64_t count = 0;
  std::memcpy(&count, bytes.data(), sizeof count);
  std::vector<Item> items(count);
  if (count > 0)
    std::memcpy(static_cast<void*>(items.data()), bytes.data() + sizeof count, count * sizeof(Item));
  bytes.remove_prefix(sizeof count + count * sizeof(Item));
  return items;
}

/// Reads the file in a child process, which hands the mesh back as plain bytes.
TriangleMesh importApart(const std::filesystem::path& path, const MeshFileLimits& limits) {
  const std::string bytes = detail::runInChild({limits.maxSeconds, limits.maxMemoryBytes}, [&] {
    Assimp::Importer importer;
    const TriangleMesh mesh = Assembler(path, import(importer, path), limits).run();
    std::string plain;
    appendBytes(mesh.vertices, plain);
    appendBytes(mesh.triangles, plain);
    return plain;
  });
  std::string_view left = bytes;
  TriangleMesh mesh;
  mesh.vertices = takeBytes<Vector3>(left);
  mesh.triangles = takeBytes<std::array<std::int32_t, 3>>(left);
  return mesh;
}

}  // namespace

TriangleMesh readMeshFile(const std::filesystem::path& path, const MeshFileLimits& limits) {
  requirePositive(limits.maxSeconds, "MeshFileLimits.maxSeconds", "s");
  require(limits.maxMemoryBytes > 0, "MeshFileLimits.maxMemoryBytes", limits.maxMemoryBytes, "bytes", "> 0");
  const std::int64_t size = checkFile(path, limits);
  checkAnnouncedCounts(path, size);
  TriangleMesh mesh;
  try {
    mesh = importApart(path, limits);
  } catch (const std::runtime_error& error) {
    const std::string what = error.what();
    if (what.starts_with("mesh file ")) throw;
    refuse(path, "cannot be read: " + oneLine(what) + " (MeshFileLimits)");
  }
  weldVertices(mesh);
  if (mesh.triangles.empty()) refuse(path, "there are no triangles");
  return mesh;
}

}  // namespace granular
