#include <momentree/models/mesh/split.hpp>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <mutex>
#include <numeric>
#include <string_view>
#include <utility>

#include <momentree/contact/shapes/solid.hpp>
#include <momentree/text/hash.hpp>

namespace momentree::io {

namespace {

using Parts = std::vector<std::vector<Vec3>>;

constexpr double flat = 1e-6;                  // missing part of the hull's volume
constexpr double covered = 0.9;                // of the mesh's volume, at least
constexpr int usual_nodes = 20, attempts = 4;  // numbers of planes that are tried across an axis

constexpr double Vec3::*axes[] = {&Vec3::x, &Vec3::y, &Vec3::z};

double signed_volume(const MeshPart& mesh) {
  double six = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 from = mesh.points[0];
    six += dot(mesh.points[i] - from, cross(mesh.points[j] - from, mesh.points[k] - from));
  }
  return six / 6;
}

// Corners that coincide become one; what is left of triangles without area is not needed.
MeshPart welded(const MeshPart& mesh) {
  MeshPart result;
  std::map<std::array<double, 3>, std::uint32_t> known;
  std::vector<std::uint32_t> corner;
  for (const Vec3& p : mesh.points) {
    const auto [found, added] = known.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(result.points.size()));
    if (added) result.points.push_back(p);
    corner.push_back(found->second);
  }
  for (const auto& [i, j, k] : mesh.triangles) {
    const std::uint32_t a = corner[i], b = corner[j], c = corner[k];
    if (a != b && b != c && c != a) result.triangles.push_back({a, b, c});
  }
  return result;
}

// True if each edge is passed as often in one direction as in the other.
bool is_oriented(const MeshPart& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> passes;
  for (const auto& triangle : mesh.triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
      passes[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  return std::all_of(passes.begin(), passes.end(), [](const auto& edge) { return edge.second == 0; });
}

// The shells of a mesh: triangles that are connected across edges of two triangles. The whole of it if one of them is open, or
// bounds a cavity of another.
std::vector<MeshPart> shells_of(const MeshPart& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<std::size_t>> beside;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::size_t k = 0; k < 3; ++k) beside[std::minmax(mesh.triangles[t][k], mesh.triangles[t][(k + 1) % 3])].push_back(t);
  std::vector<std::size_t> root(mesh.triangles.size());
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&](std::size_t t) {
    while (root[t] != t) t = root[t] = root[root[t]];
    return t;
  };
  for (const auto& [edge, triangles] : beside)
    if (triangles.size() == 2) root[find(triangles[0])] = find(triangles[1]);
  std::map<std::size_t, MeshPart> shells;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    MeshPart& shell = shells[find(t)];
    const auto n = static_cast<std::uint32_t>(shell.points.size());
    for (const std::uint32_t corner : mesh.triangles[t]) shell.points.push_back(mesh.points[corner]);
    shell.triangles.push_back({n, n + 1, n + 2});
  }
  std::vector<MeshPart> all;
  for (const auto& [number, shell] : shells) {
    all.push_back(welded(shell));
    if (!is_oriented(all.back()) || signed_volume(all.back()) < 0) return {mesh};
  }
  return all;
}

// CoACD cuts across the axes, and misses faces that lie there by a little: corners near such a face are moved onto it.
void move_onto_faces(const MeshPart& mesh, double nearness, Parts& parts) {
  for (double Vec3::*const own : axes) {
    std::vector<double> faces;
    for (const auto& [i, j, k] : mesh.triangles)
      if (const double at = mesh.points[i].*own; mesh.points[j].*own == at && mesh.points[k].*own == at) faces.push_back(at);
    std::sort(faces.begin(), faces.end());
    for (std::vector<Vec3>& part : parts)
      for (Vec3& corner : part) {
        const double at = corner.*own;
        const auto above = std::lower_bound(faces.begin(), faces.end(), at);
        double nearest = above != faces.end() ? *above : std::numeric_limits<double>::infinity();
        if (above != faces.begin() && at - *(above - 1) < nearest - at) nearest = *(above - 1);
        if (std::fabs(nearest - at) <= nearness) corner.*own = nearest;
      }
  }
}

double volume_of(const Parts& parts) {
  double sum = 0;
  for (const std::vector<Vec3>& part : parts)
    if (const contact::Solid hull = contact::hull(part); !hull.vertices.empty()) sum += contact::volume(hull);
  return sum;
}

// The C interface of CoACD, 1.0.5 and later.
struct CoacdMesh {
  double* points;
  std::uint64_t point_count;
  int* triangles;
  std::uint64_t triangle_count;
};
struct CoacdMeshes {
  CoacdMesh* meshes;
  std::uint64_t count;
};
using CoacdRun = CoacdMeshes (*)(const CoacdMesh*, double threshold, int max_convex_hull, int preprocess, int prep_resolution,
                                 int resolution, int mcts_nodes, int mcts_iterations, int mcts_max_depth, bool pca, bool merge,
                                 bool decimate, int max_ch_vertex, bool extrude, double extrude_margin, int apx_mode,
                                 unsigned seed, bool real_metric);

// What the other process has to say: an 'E' with problem and hint, or a 'P' with numbers: by part how many corners, and these.
std::string run_coacd(const MeshPart& mesh, double concavity, int nodes) {
  const char* const given = std::getenv("MOMENTREE_COACD");
  const std::string path = given != nullptr && *given != '\0' ? given : "lib_coacd.so";
  const bool in_use = ::dlopen(path.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr;
  void* const library = ::dlopen(path.c_str(), RTLD_NOW);
  if (library == nullptr) {
    const char* const why = ::dlerror();
    return std::string("Ecannot be split without CoACD: ") + (why == nullptr ? path : why) +
           "\npip install coacd; the environment variable MOMENTREE_COACD is the path of its lib_coacd.so";
  }
  // The arguments of CoACD_run() are those of this function, whose name has their types. Only newer versions have the last one.
  const std::string same = "_ZN5coacd5CoACDERKNS_4MeshEdiSsiiiiibbbibdSsj";
  if (::dlsym(library, same.c_str()) == nullptr && ::dlsym(library, (same + "b").c_str()) == nullptr)
    return "Ecannot be split: " + path + " is another version of CoACD\npip install coacd==1.0.14";
  if (in_use)  // by the caller's program, whose threads are not in this process: OpenMP would wait for them
    if (void* const set_threads = ::dlsym(library, "omp_set_num_threads")) reinterpret_cast<void (*)(int)>(set_threads)(1);
  std::vector<double> points;
  std::vector<int> triangles;
  for (const Vec3& p : mesh.points) points.insert(points.end(), {p.x, p.y, p.z});
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t corner : triangle) triangles.push_back(static_cast<int>(corner));
  const CoacdMesh whole{points.data(), mesh.points.size(), triangles.data(), mesh.triangles.size()};
  constexpr int any_number = -1, no_preprocessing = 2, hulls = 0, seed = 0;
  const auto run = reinterpret_cast<CoacdRun>(::dlsym(library, "CoACD_run"));
  const CoacdMeshes found = run(&whole, concavity, any_number, no_preprocessing, 50, 2000, nodes, 150, 3, false, true, false, 256,
                                false, 0.01, hulls, seed, false);
  std::string result = "P";
  const auto add = [&result](const double* numbers, std::size_t count) {
    result.append(reinterpret_cast<const char*>(numbers), count * sizeof(double));
  };
  for (std::uint64_t i = 0; i < found.count; ++i) {
    const CoacdMesh& part = found.meshes[i];
    const auto count = static_cast<double>(part.point_count);
    add(&count, 1), add(part.points, 3 * part.point_count);
  }
  return result;
}

// CoACD crashes on some meshes, so that it runs in a process of its own, which Ctrl-C ends. Empty if that fails at any point.
std::string in_a_process(const std::function<std::string()>& work) {
  constexpr std::string_view whole = "whole";  // ends what the process writes
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return {};
  const pid_t process = fork();
  if (process == 0) {
    std::signal(SIGINT, SIG_DFL), std::signal(SIGTERM, SIG_DFL);
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // nor does it outlive this one
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    if (nowhere >= 0) ::dup2(nowhere, STDOUT_FILENO), ::dup2(nowhere, STDERR_FILENO);
    const std::string result = work() + std::string(whole);
    for (std::size_t done = 0; done < result.size();) {
      const ssize_t n = ::write(ends[1], result.data() + done, result.size() - done);
      if (n <= 0) ::_exit(1);
      done += static_cast<std::size_t>(n);
    }
    ::_exit(0);
  }
  ::close(ends[1]);
  std::string result;
  char buffer[4096];
  for (ssize_t n = 1; process > 0 && n != 0;) {
    n = ::read(ends[0], buffer, sizeof buffer);
    if (n < 0 && errno != EINTR) break;
    if (n > 0) result.append(buffer, static_cast<std::size_t>(n));
  }
  ::close(ends[0]);
  int status = 0;
  while (process > 0 && ::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGINT) return "Ecannot be split: interrupted\na larger split takes less time";
  if (!result.ends_with(whole)) return {};
  result.resize(result.size() - whole.size());
  return result;
}

Parts parts_by_coacd(const MeshPart& mesh, double concavity, int nodes, SplitMesh& result) {
  const std::string said = in_a_process([&] { return run_coacd(mesh, concavity, nodes); });
  Parts parts;
  if (said.starts_with('E')) {
    const std::size_t line = said.find('\n');
    result.problem = said.substr(1, line - 1), result.hint = said.substr(line + 1);
  } else if (said.size() > 1) {
    std::vector<double> numbers((said.size() - 1) / sizeof(double));
    std::memcpy(numbers.data(), said.data() + 1, numbers.size() * sizeof(double));
    for (std::size_t i = 0; i < numbers.size();) {
      std::vector<Vec3>& part = parts.emplace_back();
      const auto count = static_cast<std::size_t>(numbers[i++]);
      for (std::size_t k = 0; k < count && i + 2 < numbers.size(); ++k, i += 3)
        part.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
    }
  }
  return parts;
}

double extent_of(const MeshPart& mesh) {
  double extent = 0;
  for (double Vec3::*const own : axes) {
    const auto [least, most] = std::minmax_element(mesh.points.begin(), mesh.points.end(),
                                                   [own](const Vec3& a, const Vec3& b) { return a.*own < b.*own; });
    extent = std::max(extent, (*most).*own - (*least).*own);
  }
  return extent;
}

Parts parts_of_shell(const MeshPart& shell, double concavity, SplitMesh& result) {
  const double volume = signed_volume(shell);
  if (const contact::Solid hull = contact::hull(shell.points);
      hull.vertices.empty() || volume >= (1 - flat) * contact::volume(hull))
    return {shell.points};
  for (int nodes = usual_nodes; nodes < usual_nodes + attempts; ++nodes) {
    Parts parts = parts_by_coacd(shell, concavity, nodes, result);
    if (!result.problem.empty()) return {};
    move_onto_faces(shell, concavity / 2 * extent_of(shell), parts);
    std::erase_if(parts, [](const std::vector<Vec3>& part) { return contact::hull(part).vertices.empty(); });
    if (volume_of(parts) >= covered * volume) return parts;
  }
  result.problem = "cannot be split: CoACD fails";
  result.hint = "see whether it intersects itself, try another split, or divide it by another program";
  return {};
}

SplitMesh split(MeshPart mesh, double concavity) {
  SplitMesh result;
  if (!is_oriented(mesh)) {
    result.problem = "cannot be split: some of its triangles face inwards, others outwards";
    result.hint = "let all of them face outwards";
    return result;
  }
  if (signed_volume(mesh) < 0)
    for (auto& triangle : mesh.triangles) std::swap(triangle[0], triangle[1]);
  for (const MeshPart& shell : shells_of(mesh)) {
    Parts parts = parts_of_shell(shell, concavity, result);
    if (!result.problem.empty()) return {{}, result.problem, result.hint};
    std::move(parts.begin(), parts.end(), std::back_inserter(result.parts));
  }
  return result;
}

template <class T>
std::string_view bytes_of(const std::vector<T>& all) {
  return {reinterpret_cast<const char*>(all.data()), all.size() * sizeof(T)};
}

}  // namespace

std::shared_ptr<const SplitMesh> split_mesh(const MeshPart& mesh, double concavity) {
  MeshPart whole = welded(mesh);
  Hash hash;
  hash.add(bytes_of(whole.points)), hash.add(bytes_of(whole.triangles)), hash.add(bytes_of(std::vector<double>{concavity}));
  static std::mutex one_at_a_time;
  static std::map<std::string, std::shared_ptr<const SplitMesh>> known;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  std::shared_ptr<const SplitMesh>& kept = known[hash.digits()];
  if (!kept || !kept->problem.empty()) kept = std::make_shared<const SplitMesh>(split(std::move(whole), concavity));
  return kept;
}

}  // namespace momentree::io
